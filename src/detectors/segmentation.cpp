#include "ipm_mapping/detectors/segmentation.hpp"

#include <algorithm>

namespace ipm_mapping {

Segmentation::Result Segmentation::process(GrayView difference, GrayView valid,
                                           GrayBuffer obstacle_mask) {
  for (Image<std::uint8_t>* image : {&blurred_, &blurred_valid_, &binary_, &eroded_})
    image->ensure(difference.width, difference.height);
  gaussian_(difference, valid, blurred_.view(), blurred_valid_.view());          // eq. 6.7
  const auto found = otsu(histogramOf(blurred_.view(), blurred_valid_.view()));  // eq. 3.30

  // No two classes: the threshold stays what it was.
  const int previous = has_threshold_ ? threshold_ : 255;
  if (found) {
    threshold_ = found->threshold;
    has_threshold_ = true;
  }
  Result result;
  result.separability = found ? static_cast<float>(found->separability) : 0.0F;
  result.threshold =
      std::max(parameters_.previous_threshold ? previous : (has_threshold_ ? threshold_ : 255),
               parameters_.min_threshold);
  const bool separable = result.separability >= static_cast<float>(parameters_.min_separability);

  binarize(blurred_.view(), blurred_valid_.view(), separable ? result.threshold : 255,
           binary_.view());
  erosion_(binary_.view(), eroded_.view());
  mask::compose(eroded_.view(), blurred_valid_.view(), obstacle_mask);
  return result;
}

}  // namespace ipm_mapping
