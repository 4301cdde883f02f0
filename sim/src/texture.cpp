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
  }
  return {};
}

/// Rounded blotches with thin dark rims for stone, the plain sum elsewhere.
float shape(Grain grain, float sum) {
  if (grain == Grain::Speckle) return std::tanh(1.4F * sum);
  if (grain == Grain::Wood) return std::tanh(1.2F * sum) + 0.25F * std::sin(9.0F * sum);
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

std::vector<float> padded(const std::vector<float>& texels, int n) {
  std::vector<float> out;
  out.reserve(static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 1));
  for (int j = 0; j <= n; ++j) {
    const float* row = texels.data() + static_cast<std::ptrdiff_t>(j % n) * n;
    out.insert(out.end(), row, row + n);
    out.push_back(row[0]);
  }
  return out;
}

}  // namespace

Texture::Texture(Grain grain, std::uint64_t seed) {
  std::vector<float> texels = baseLevel(grain, seed);
  for (int level = 0; level < kLevels; ++level) {
    levels_[level] = padded(texels, kSize >> level);
    if (level + 1 < kLevels) texels = halved(texels, kSize >> level);
  }
  const Octave finest = octavesOf(grain).back();
  const int spacing = kSize / std::max(finest.cells_s, finest.cells_t);
  while ((4 << smooth_level_) < spacing) ++smooth_level_;
}

float Texture::sum(int level, const Taps& taps) const {
  const int n = kSize >> level, mask = n - 1;
  const auto scale = static_cast<float>(n);
  const float* texels = levels_[level].data();
  float total = 0.0F;
  for (int k = 0; k < taps.count; ++k) {
    const float x = (taps.first.x() + static_cast<float>(k) * taps.step.x()) * scale - 0.5F;
    const float y = (taps.first.y() + static_cast<float>(k) * taps.step.y()) * scale - 0.5F;
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
    const float* low = texels + (j & mask) * (n + 1) + (i & mask);
    const float* high = low + n + 1;
    const float left = low[0] + v * (high[0] - low[0]), right = low[1] + v * (high[1] - low[1]);
    total += left + u * (right - left);
  }
  return total;
}

float Texture::sample(Eigen::Vector2f p, const Footprint2& pixel) const {
  constexpr float longest = 6.0F;  // taps along a stretched footprint
  const float xx = pixel.dx.squaredNorm(), yy = pixel.dy.squaredNorm();
  const Eigen::Vector2f major = xx > yy ? pixel.dx : pixel.dy;
  const float length = std::sqrt(std::max(xx, yy)) * kSize;
  const Eigen::Vector2f inside(p.x() - static_cast<float>(floorOf(p.x())),
                               p.y() - static_cast<float>(floorOf(p.y())));
  const auto smooth = static_cast<float>(1 << smooth_level_);
  if (length <= 1.4F * smooth) {
    return sum(smooth_level_, {inside.array() + 1.0F, Eigen::Vector2f::Zero(), 1});
  }
  const float area = std::abs(pixel.dx.x() * pixel.dy.y() - pixel.dx.y() * pixel.dy.x());
  const float across = area * kSize * kSize / length;
  const float minor = std::max(across, std::max(length / longest, smooth));
  const float level = std::log2(minor) - 0.5F;
  const int fine = static_cast<int>(level);
  if (fine >= kLevels - 3) return levels_[kLevels - 1][0];
  const int count = std::max(1, static_cast<int>(length / minor + 0.75F));
  const float share = 1.0F / static_cast<float>(count);
  const Taps taps{(inside + (0.5F * share - 0.5F) * major).array() + 4.0F, share * major, count};
  if (level <= static_cast<float>(smooth_level_)) return share * sum(smooth_level_, taps);
  const float a = sum(fine, taps), b = sum(fine + 1, taps);
  return share * (a + (level - static_cast<float>(fine)) * (b - a));
}

const Texture* TextureSet::get(Grain grain) {
  if (grain == Grain::None) return nullptr;
  auto& texture = textures_[static_cast<std::size_t>(grain)];
  if (!texture) texture = std::make_unique<Texture>(grain, seed_);
  return texture.get();
}

float gapCoverage(float x, float extent, float period, float gap) {
  const float box = std::max(extent, 1e-6F), per_metre = 1.0F / period;
  const auto integral = [&](float at) {  // of the gaps' indicator from 0 to `at`
    const float shifted = at + 0.5F * gap;
    const auto cell = static_cast<float>(floorOf(shifted * per_metre));
    return cell * gap + std::min(shifted - cell * period, gap);
  };
  return (integral(x + 0.5F * box) - integral(x - 0.5F * box)) / box;
}

float edgeCoverage(float inside, float extent) {
  return std::clamp(0.5F + inside / std::max(extent, 1e-6F), 0.0F, 1.0F);
}

}  // namespace ipm_mapping::sim
