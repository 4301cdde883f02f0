#include "ipm_mapping_sim/texture.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping_sim/random.hpp"

namespace ipm_mapping::sim {
namespace {

/// Periodic value noise with a smooth step between lattice points; `cells_*` a repeat.
class ValueNoise {
 public:
  ValueNoise(int cells_s, int cells_t, std::uint64_t seed)
      : cells_s_(cells_s), cells_t_(cells_t), seed_(seed) {}

  [[nodiscard]] float operator()(float s, float t) const {
    const float x = s * static_cast<float>(cells_s_), y = t * static_cast<float>(cells_t_);
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    const float u = smooth(x - std::floor(x)), v = smooth(y - std::floor(y));
    const float low = lattice(i, j) + u * (lattice(i + 1, j) - lattice(i, j));
    const float high = lattice(i, j + 1) + u * (lattice(i + 1, j + 1) - lattice(i, j + 1));
    return low + v * (high - low);
  }

 private:
  static float smooth(float f) { return f * f * (3.0F - 2.0F * f); }
  [[nodiscard]] float lattice(int i, int j) const {
    return signedFloat(cellHash(seed_, (i + cells_s_) % cells_s_, (j + cells_t_) % cells_t_));
  }

  int cells_s_, cells_t_;
  std::uint64_t seed_;
};

struct Octave {
  int cells_s, cells_t;
  float weight;
};

std::vector<Octave> octavesOf(Grain grain) {
  switch (grain) {
    case Grain::None:
      return {};
    case Grain::Speckle:
      return {{24, 24, 0.35F}, {96, 96, 0.7F}, {192, 192, 0.9F}, {384, 384, 0.5F}};
    case Grain::Clouds:
      return {{4, 4, 0.8F}, {9, 9, 0.6F}, {21, 21, 0.4F}, {53, 53, 0.25F}};
    case Grain::Wood:
      return {{2, 24, 0.5F}, {4, 90, 0.7F}, {9, 230, 0.6F}, {30, 400, 0.35F}};
    case Grain::Fibre:
      return {{30, 30, 0.3F}, {200, 200, 0.9F}, {400, 400, 0.9F}};
    case Grain::Concrete:
      return {{3, 3, 0.5F}, {8, 8, 0.5F}, {22, 22, 0.4F}, {70, 70, 0.4F}, {210, 210, 0.5F}};
    case Grain::Marble:
      return {{7, 7, 0.6F}, {15, 15, 0.5F}, {33, 33, 0.25F}, {150, 150, 0.1F}};
  }
  return {};
}

/// Rounded blotches with thin dark rims for stone, dark veins for marble, the plain sum elsewhere.
float shape(Grain grain, float sum) {
  if (grain == Grain::Speckle) return std::tanh(1.4F * sum);
  if (grain == Grain::Wood) return std::tanh(1.2F * sum) + 0.25F * std::sin(9.0F * sum);
  if (grain == Grain::Marble) return std::tanh(4.0F * std::abs(sum));
  return sum;
}

std::vector<float> baseLevel(Grain grain, std::uint64_t seed) {
  std::vector<ValueNoise> noises;
  const std::vector<Octave> octaves = octavesOf(grain);
  for (std::size_t k = 0; k < octaves.size(); ++k) {
    noises.emplace_back(octaves[k].cells_s, octaves[k].cells_t,
                        hashOf(seed, static_cast<std::uint64_t>(grain), k));
  }
  constexpr int n = Texture::kSize;
  std::vector<float> texels(static_cast<std::size_t>(n) * n);
  double mean = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const float s = (static_cast<float>(i) + 0.5F) / n, t = (static_cast<float>(j) + 0.5F) / n;
      float sum = 0.0F;
      for (std::size_t k = 0; k < noises.size(); ++k) sum += octaves[k].weight * noises[k](s, t);
      float& texel = texels[static_cast<std::size_t>(j) * n + static_cast<std::size_t>(i)];
      texel = shape(grain, sum);
      mean += static_cast<double>(texel);
    }
  }
  const auto offset = static_cast<float>(mean / static_cast<double>(texels.size()));
  for (float& texel : texels) texel -= offset;
  return texels;
}

std::vector<float> halved(const std::vector<float>& fine, int n) {
  const int half = n / 2;
  std::vector<float> coarse(static_cast<std::size_t>(half) * static_cast<std::size_t>(half));
  for (int j = 0; j < half; ++j) {
    const float* a = fine.data() + static_cast<std::ptrdiff_t>(2 * j) * n;
    const float* b = a + n;
    for (int i = 0; i < half; ++i) {
      coarse[static_cast<std::size_t>(j * half + i)] =
          0.25F * (a[2 * i] + a[2 * i + 1] + b[2 * i] + b[2 * i + 1]);
    }
  }
  return coarse;
}

void appendPadded(const std::vector<float>& texels, int n, std::vector<float>& out) {
  for (int j = 0; j <= n; ++j) {
    const float* row = texels.data() + static_cast<std::ptrdiff_t>(j % n) * n;
    out.insert(out.end(), row, row + n);
    out.push_back(row[0]);
  }
}

}  // namespace

Texture::Texture(Grain grain, std::uint64_t seed) {
  std::vector<float> texels = baseLevel(grain, seed);
  for (int level = 0; level < kLevels; ++level) {
    first_[level] = static_cast<std::int32_t>(texels_.size());
    appendPadded(texels, kSize >> level, texels_);
    if (level + 1 < kLevels) texels = halved(texels, kSize >> level);
  }
  const Octave finest = octavesOf(grain).back();
  const int spacing = kSize / std::max(finest.cells_s, finest.cells_t);
  while ((4 << smooth_level_) < spacing) ++smooth_level_;
}

/// Up to six taps along the footprint's longer axis, on the level that its shorter one asks for.
SIM_LANES void Texture::place(const Lanes2& p, const FootprintPacket& pixel, float repeat,
                              Taps& taps) const {
  constexpr float longest = 6.0F;
  const float scale = 1.0F / repeat, texels = scale * kSize;
  const auto smooth = static_cast<float>(1 << smooth_level_);
  const int finest = smooth_level_;
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float ax = pixel.dx.x[k], ay = pixel.dx.y[k], bx = pixel.dy.x[k], by = pixel.dy.y[k];
    const float aa = ax * ax + ay * ay, bb = bx * bx + by * by;
    const float major_x = scale * (aa > bb ? ax : bx), major_y = scale * (aa > bb ? ay : by);
    const float length = texels * std::sqrt(std::max(aa, bb));
    const float across = std::abs(ax * by - ay * bx) * texels * texels / std::max(length, 1e-9F);
    const float minor = std::max(across, std::max(length / longest, smooth));
    const bool fine = length <= 1.4F * smooth;  // one tap is as good as the footprint
    const float wanted = std::max(log2Of(minor) - 0.5F, static_cast<float>(finest));
    const float coarse = wanted < kLevels - 3 ? wanted : kLevels - 1;  // the mean of all
    const float level = fine ? 0.0F : coarse;
    const int whole = std::min(static_cast<int>(level), kLevels - 2);
    const int count = fine ? 1 : std::max(1, static_cast<int>(length / minor + 0.75F));
    const float share = 1.0F / static_cast<float>(count), x = scale * p.x[k], y = scale * p.y[k];
    taps.step.x[k] = fine ? 0.0F : share * major_x;
    taps.step.y[k] = fine ? 0.0F : share * major_y;
    const float before = 0.5F * static_cast<float>(count - 1);
    taps.first.x[k] = x - static_cast<float>(floorOf(x)) - before * taps.step.x[k] + 4.0F;
    taps.first.y[k] = y - static_cast<float>(floorOf(y)) - before * taps.step.y[k] + 4.0F;
    taps.count[k] = count;
    taps.level[k] = std::max(whole, finest);
    const float rest = level - static_cast<float>(whole);
    taps.finer[k] = fine ? 1.0F : 1.0F - std::min(rest, 1.0F);
  }
  for (int k = 0; k < kPacket; ++k) {
    taps.longest = std::max(taps.longest, taps.count[k]);
    taps.blends |= taps.finer[k] < 1.0F;
  }
}

/// Adds one tap of the footprints that have it, on the tap's level or on the next coarser one.
SIM_LANES void Texture::addTap(const Taps& taps, int tap, int coarser, Lanes& sum) const {
  const float* all = texels_.data();
  Lanes2 fraction;
  IntLanes at, stride;
  for (int k = 0; k < kPacket; ++k) {
    const int level = taps.level[k] + coarser, n = kSize >> level;
    stride[k] = n + 1;
    at[k] = first_[level];
  }
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const int mask = stride[k] - 2;
    const auto size = static_cast<float>(stride[k] - 1), t = static_cast<float>(tap);
    const float x = (taps.first.x[k] + t * taps.step.x[k]) * size - 0.5F;
    const float y = (taps.first.y[k] + t * taps.step.y[k]) * size - 0.5F;
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    fraction.x[k] = x - static_cast<float>(i);
    fraction.y[k] = y - static_cast<float>(j);
    at[k] += (j & mask) * stride[k] + (i & mask);
  }
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const int low = at[k], high = low + stride[k];
    const float left = all[low] + fraction.y[k] * (all[high] - all[low]);
    const float right = all[low + 1] + fraction.y[k] * (all[high + 1] - all[low + 1]);
    const float value = left + fraction.x[k] * (right - left);
    const float level = coarser == 0 ? taps.finer[k] : 1.0F - taps.finer[k];
    const float share = tap < taps.count[k] ? 1.0F / static_cast<float>(taps.count[k]) : 0.0F;
    sum[k] += share * level * value;
  }
}

void Texture::sample(const Lanes2& p, const FootprintPacket& pixel, float repeat,
                     Lanes& out) const {
  Taps taps;
  place(p, pixel, repeat, taps);
  Lanes sum{};
  for (int tap = 0; tap < taps.longest; ++tap) {
    addTap(taps, tap, 0, sum);
    if (taps.blends) addTap(taps, tap, 1, sum);
  }
  out = sum;
}

const Texture* TextureSet::get(Grain grain) {
  if (grain == Grain::None) return nullptr;
  auto& texture = textures_[static_cast<std::size_t>(grain)];
  if (!texture) texture = std::make_unique<Texture>(grain, seed_);
  return texture.get();
}

}  // namespace ipm_mapping::sim
