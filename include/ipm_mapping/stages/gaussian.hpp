#pragma once

#include <vector>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// 3x3 Gaussian [1 2 1; 2 4 2; 1 2 1] / 16, rounded to nearest (eq. 6.7, which supersedes
/// fig. 3.6).
///
/// Invalid pixels have to be 0 in `image`: they enter the sum as 0, without renormalisation. The
/// output is valid (255) where the centre is valid and not on the border; 0 elsewhere.
class Gaussian {
 public:
  void operator()(GrayView image, GrayView valid, GrayBuffer blurred, GrayBuffer blurred_valid);

 private:
  std::vector<std::uint16_t> column_sums_;
};

}  // namespace ipm_mapping
