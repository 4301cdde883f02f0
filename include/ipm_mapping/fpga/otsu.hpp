#pragma once
// Twin of histogram, Otsu's threshold and binarisation (the source, §6.6; rule 9).

#include <array>
#include <cstdint>
#include <optional>

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::fpga {

using GreyHistogram = std::array<std::uint32_t, 256>;

/// Counts the Gaussian pixels that have a correspondence.
void histogram(ImageView<const TaggedPixel> gaussian, GreyHistogram& bins);

/// Grey level with the greatest between-class variance, first one wins; nothing when no level
/// splits the pixels into two classes.
[[nodiscard]] std::optional<std::uint8_t> otsuThreshold(const GreyHistogram& bins);

/// What the mask is compared with: the register before the frame, but not less than min_threshold.
[[nodiscard]] int maskThreshold(int threshold_in, int min_threshold);

/// 1 where a pixel has a correspondence and exceeds the threshold.
void binarise(ImageView<const TaggedPixel> gaussian, int threshold, ImageView<std::uint8_t> mask);

/// Threshold register between two frames.
class ThresholdRegister {
 public:
  static constexpr std::uint8_t reset_value = 255;

  void reset() { value_ = reset_value; }
  /// Loads what a frame's Otsu stage put out.
  void load(std::uint8_t threshold_out) { value_ = threshold_out; }
  [[nodiscard]] std::uint8_t value() const { return value_; }

 private:
  std::uint8_t value_ = reset_value;
};

}  // namespace ipm_mapping::fpga
