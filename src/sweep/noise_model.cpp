#include "ipm_mapping/sweep/noise_model.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr int widest_stride = 8;

/// Half-width in fine rows that spans about a pixel on either side: far rows oversample the image.
int strideAt(double r, double slope_step, double rows_per_log) {
  return std::clamp(static_cast<int>(std::lround(slope_step * rows_per_log / r)), 1, widest_stride);
}

float square(double x) { return static_cast<float>(x * x); }

}  // namespace

void NoiseModel::configure(const PolarGrid& grid, const std::vector<RowRange>& rows,
                           const NoiseParameters& p) {
  terms_.dark = static_cast<float>(p.sigma * p.sigma * p.dark_share);
  terms_.bright = static_cast<float>(p.sigma * p.sigma / p.bright_unit);
  terms_.across = square(0.5 * p.azimuth_error * grid.lines_per_radian);
  terms_.bend_across = square(p.blur_azimuth * grid.lines_per_radian);
  const auto n = static_cast<std::size_t>(grid.sweepRows());
  along_.resize(n + kernels::overrun);
  bend_along_.resize(n + kernels::overrun);
  segments_.clear();
  for (int j = 0; j < grid.sweepRows(); ++j) {
    const double r = grid.r(j * PolarGrid::rows_per_sweep_row);
    const int stride = strideAt(r, p.slope_step, grid.rows_per_log);
    const double slope_per_step = stride * r / grid.rows_per_log;
    along_[static_cast<std::size_t>(j)] = square(0.5 * p.slope_error / slope_per_step);
    bend_along_[static_cast<std::size_t>(j)] = square(p.blur_slope / slope_per_step);
    if (segments_.empty() || segments_.back().stride != stride)
      segments_.push_back({{j, j}, stride});
    segments_.back().rows.end = j + 1;
  }
  interior_.assign(static_cast<std::size_t>(grid.lines), RowRange{});
  for (std::size_t line = 1; line + 1 < interior_.size(); ++line) {
    RowRange both = intersection(rows[line], intersection(rows[line - 1], rows[line + 1]));
    if (both.size() > 2 * widest_stride)
      interior_[line] = {(both.begin + widest_stride + 1) / 2, (both.end - 2) / 2};
  }
}

void NoiseModel::evaluate(ImageView<const std::int16_t> even, ImageView<const std::int16_t> odd,
                          ImageView<std::uint16_t> weights) const {
  for (int line = 1; line + 1 < even.height; ++line) {
    for (const Segment& segment : segments_) {
      const RowRange rows = intersection(segment.rows, sweepRows(line));
      if (rows.size() == 0) continue;
      // sweep row j is fine row 2 j: its neighbours are even rows or odd ones
      const std::int16_t* plane = (segment.stride % 2 == 0 ? even : odd).row(line) + rows.begin;
      const kernels::NoiseNeighbours grey{
          even.row(line) + rows.begin, even.row(line - 1) + rows.begin,
          even.row(line + 1) + rows.begin, plane - (segment.stride + 1) / 2,
          plane + segment.stride / 2};
      kernels::noiseWeights(grey, along_.data() + rows.begin, bend_along_.data() + rows.begin,
                            terms_, rows.size(), weights.row(line) + rows.begin);
    }
  }
}

}  // namespace ipm_mapping::sweep
