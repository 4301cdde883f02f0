#pragma once

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/stages/erosion.hpp"
#include "ipm_mapping/stages/gaussian.hpp"
#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "ipm_mapping/stages/otsu.hpp"

namespace ipm_mapping {

/// Second link of the chain: Gaussian, Otsu, erosion (the source, §3.4, §6.5-6.7).
class Segmentation {
 public:
  explicit Segmentation(const SegmentationParameters& parameters = {}) : parameters_(parameters) {}

  struct Result {
    int threshold = 0;       ///< grey levels that the mask was made with
    float separability = 0;  ///< between-class share of the variance, 0..1
  };
  /// difference, valid (255 or 0) in; mask (mask::floor, unseen, obstacle) out; all W x H.
  Result process(GrayView difference, GrayView valid, GrayBuffer obstacle_mask);
  /// Forgets the previous threshold.
  void reset() { has_threshold_ = false; }
  void setParameters(const SegmentationParameters& parameters) { parameters_ = parameters; }

  /// The blurred difference of the last process(), W x H.
  [[nodiscard]] GrayView blurred() const { return blurred_.view(); }

 private:
  SegmentationParameters parameters_;
  Gaussian gaussian_;
  Erosion erosion_;
  Image<std::uint8_t> blurred_, blurred_valid_, binary_, eroded_;
  int threshold_ = 255;
  bool has_threshold_ = false;
};

}  // namespace ipm_mapping
