#pragma once
// From light to grey levels: lens blur, exposure, vignetting, noise, tone curve, eight bits.

#include <cstdint>
#include <vector>

#include "ipm_mapping_sim/scene.hpp"

namespace ipm_mapping::sim {

class Sensor {
 public:
  Sensor(const SensorSpec& spec, int width, int height, std::uint64_t seed);

  /// Relative exposure of frame `frame` at `time` seconds.
  [[nodiscard]] double gain(int frame, double time) const;
  /// Grey levels of a frame; `radiance` is row-major linear light and is blurred in place.
  void expose(int frame, double time, std::vector<float>& radiance,
              std::vector<std::uint8_t>& grey);
  /// Grey level of linear light without noise.
  [[nodiscard]] std::uint8_t tone(float light) const;

 private:
  void blur(std::vector<float>& image);

  SensorSpec spec_;
  int width_, height_;
  std::uint64_t seed_;
  float kernel_[3];
  std::vector<std::uint8_t> tones_;
  std::vector<float> vignette_, scratch_;
};

}  // namespace ipm_mapping::sim
