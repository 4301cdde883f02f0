#pragma once

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::sweep {

/// Grey level between pixels of a rectified image and its slopes there.
struct GreyPatch {
  double value, by_row, by_line;
};

/// `row` and `line` have to lie between pixels of the image.
[[nodiscard]] inline GreyPatch greyPatch(const Image<std::uint8_t>& image, double row,
                                         double line) {
  const int ir = static_cast<int>(row), il = static_cast<int>(line);
  const double a = row - ir, b = line - il;
  const std::uint8_t* p = image.row(il) + ir;
  const std::uint8_t* q = p + image.width();
  const double here = p[0] + a * (p[1] - p[0]), next = q[0] + a * (q[1] - q[0]);
  return {here + b * (next - here), (p[1] - p[0]) + b * ((q[1] - q[0]) - (p[1] - p[0])),
          next - here};
}

/// Tukey's biweight: 1 at e = 0, 0 from |e| = limit on.
[[nodiscard]] inline double tukeyWeight(double e, double limit) {
  const double share = e / limit, rest = 1.0 - share * share;
  return rest > 0.0 ? rest * rest : 0.0;
}

}  // namespace ipm_mapping::sweep
