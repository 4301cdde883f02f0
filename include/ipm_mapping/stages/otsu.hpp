#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

using Histogram = std::array<std::uint32_t, 256>;

/// Grey levels of the pixels whose valid is not 0. Invalid pixels have to be 0 in `image`, as the
/// Gaussian leaves them.
[[nodiscard]] Histogram histogramOf(GrayView image, GrayView valid);

/// Otsu's threshold (the source, §3.4.2).
struct Otsu {
  int threshold;        ///< class 0 is grey <= threshold
  double separability;  ///< between-class share of the total variance, 0..1
};

/// The first k that maximises w0 w1 (mu1 - mu0)^2 (eq. 3.30); class 0 is <= k, empty classes are
/// skipped. Nothing where no k leaves two classes.
[[nodiscard]] std::optional<Otsu> otsu(const Histogram& histogram);

/// 255 where grey > threshold (0 ... 255) and valid, else 0.
void binarize(GrayView image, GrayView valid, int threshold, GrayBuffer binary);

}  // namespace ipm_mapping
