#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::sweep {

/// Grey levels of a plane, summed over the lines of a beam from each line on and over the rows
/// before each row: the mean brightness of any upright patch in a few reads.
class BeamSums {
 public:
  /// For planes of so many rows and lines; sums begin at every step-th line.
  void configure(int rows, int lines, int step = 1);
  /// `plane` in 1/32 grey levels.
  void evaluate(ImageView<const std::int16_t> plane);

  [[nodiscard]] ImageView<const std::int32_t> view() const { return sums_.view(); }

 private:
  Image<std::int32_t> sums_;          // rows + 1 x first lines
  std::vector<std::int32_t> column_;  // the lines of the present beam together
  int step_ = 1;
};

/// A patch of a plane: rows begin ... end - 1 of the lines of a beam, all of it moved by whole
/// lines and rows and by fractions of one in 1/2^15.
struct BeamPatch {
  int begin = 0, end = 0;
  std::int32_t line = 0, line_fraction = 0;
  std::int32_t row = 0, row_fraction = 0;
};
/// Its grey levels together. Reads one line and one row more, rows end at most at those of the
/// plane.
inline float sumOf(ImageView<const std::int32_t> sums, const BeamPatch& patch) {
  constexpr float unit = 1.0F / 32768.0F;
  const auto along = [&](const std::int32_t* sum) {
    const std::int32_t *from = sum + patch.begin + patch.row, *to = sum + patch.end + patch.row;
    const std::int32_t here = to[0] - from[0], next = to[1] - from[1];
    return static_cast<float>(here) +
           static_cast<float>(next - here) * (static_cast<float>(patch.row_fraction) * unit);
  };
  const float here = along(sums.row(patch.line)), next = along(sums.row(patch.line + 1));
  return here + (next - here) * (static_cast<float>(patch.line_fraction) * unit);
}

}  // namespace ipm_mapping::sweep
