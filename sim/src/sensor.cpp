#include "ipm_mapping_sim/sensor.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping_sim/random.hpp"

namespace ipm_mapping::sim {
namespace {

constexpr int kTones = 1 << 16;

/// The sRGB curve, which cameras' eight-bit images follow.
double encoded(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}

}  // namespace

Sensor::Sensor(const SensorSpec& spec, int width, int height, std::uint64_t seed)
    : spec_(spec), width_(width), height_(height), seed_(seed) {
  for (int i = 0; i <= kTones; ++i) {
    tones_.push_back(
        static_cast<std::uint8_t>(std::lround(255.0 * encoded(static_cast<double>(i) / kTones))));
  }
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1), corner = cx * cx + cy * cy;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double share = ((u - cx) * (u - cx) + (v - cy) * (v - cy)) / corner;
      vignette_.push_back(static_cast<float>(1.0 - spec.vignetting * share));
    }
  }
  double sum = 0.0, weights[3];
  for (int k = 0; k < 3; ++k) {
    weights[k] = spec.blur > 0.0 ? std::exp(-0.5 * k * k / (spec.blur * spec.blur)) : (k == 0);
    sum += (k == 0 ? 1 : 2) * weights[k];
  }
  for (int k = 0; k < 3; ++k) kernel_[k] = static_cast<float>(weights[k] / sum);
}

double Sensor::gain(int frame, double time) const {
  const auto bits = hashOf(seed_, static_cast<std::uint64_t>(Stream::Exposure),
                           static_cast<std::uint64_t>(frame));
  const double flicker = static_cast<double>(normalFloat(static_cast<std::uint32_t>(bits >> 40)));
  const double drift = std::sin(2.0 * M_PI * time / spec_.drift_period);
  return spec_.exposure * (1.0 + spec_.drift * drift) * (1.0 + spec_.flicker * flicker);
}

std::uint8_t Sensor::tone(float light) const {
  return tones_[static_cast<std::size_t>(std::clamp(light, 0.0F, 1.0F) * kTones)];
}

void Sensor::blur(std::vector<float>& image) {
  if (spec_.blur <= 0.0) return;
  scratch_.resize(image.size());
  const auto pass = [this](const float* in, float* out, int i, int n, std::ptrdiff_t stride) {
    const auto at = [&](int k) { return in[std::clamp(i + k, 0, n - 1) * stride]; };
    out[i * stride] =
        kernel_[0] * at(0) + kernel_[1] * (at(-1) + at(1)) + kernel_[2] * (at(-2) + at(2));
  };
  for (int v = 0; v < height_; ++v) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(v) * width_;
    for (int u = 0; u < width_; ++u) pass(&image[0] + row, &scratch_[0] + row, u, width_, 1);
  }
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) pass(&scratch_[0] + u, &image[0] + u, v, height_, width_);
  }
}

void Sensor::expose(int frame, double time, std::vector<float>& radiance,
                    std::vector<std::uint8_t>& grey) {
  blur(radiance);
  grey.resize(radiance.size());
  const auto gain = static_cast<float>(this->gain(frame, time));
  const auto well = static_cast<float>(spec_.full_well);
  const auto dark = static_cast<float>(spec_.read_noise * spec_.read_noise);
  const std::uint64_t stream =
      hashOf(seed_, static_cast<std::uint64_t>(Stream::Sensor), static_cast<std::uint64_t>(frame));
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const float electrons = well * std::min(gain * vignette_[i] * radiance[i], 2.0F);
    const auto bits = static_cast<std::uint32_t>(mixBits(stream + i) >> 40);
    grey[i] = tone((electrons + std::sqrt(electrons + dark) * normalFloat(bits)) / well);
  }
}

}  // namespace ipm_mapping::sim
