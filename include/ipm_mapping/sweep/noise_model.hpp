#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// How much a grey level may differ between two views of the same thing:
///   variance = sigma^2 (dark_share + I / bright_unit) + (azimuth_error dI/daz)^2
///            + (slope_error dI/dr)^2 + (blur_azimuth^2 d2I/daz2 + blur_slope^2 d2I/dr2)^2,
/// sensor noise, misregistration and unequal sharpness. Texture and joints explain their own
/// residual. Stored as 32768 / standard deviation on the sweep rows.
class NoiseModel {
 public:
  void configure(const PolarGrid& grid, const std::vector<RowRange>& rows,
                 const NoiseParameters& parameters);

  /// `even` and `odd` are the rows of the current image, 1/32 grey levels; all sweepRows x lines.
  void evaluate(ImageView<const std::int16_t> even, ImageView<const std::int16_t> odd,
                ImageView<std::uint16_t> weights) const;

  /// Sweep rows of a line whose neighbourhood is in view: where weights are valid.
  [[nodiscard]] RowRange sweepRows(int line) const {
    return interior_[static_cast<std::size_t>(line)];
  }
  [[nodiscard]] const std::vector<RowRange>& sweepRows() const { return interior_; }

 private:
  /// Sweep rows that share the width of the difference along the line.
  struct Segment {
    RowRange rows;
    int stride;
  };

  std::vector<Segment> segments_;
  std::vector<RowRange> interior_;
  std::vector<float> along_, bend_along_;
  kernels::NoiseTerms terms_;
};

}  // namespace ipm_mapping::sweep
