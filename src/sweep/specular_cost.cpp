#include "ipm_mapping/sweep/specular_cost.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {

void SpecularCost::configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                             const EvidenceParameters& p) {
  grid_ = grid;
  reference_rows_ = commonRows(reference_rows, kernels::beam_lines + 1);
  parallax_ = p.specular_parallax;
  prior_ = static_cast<std::int32_t>(std::lround(p.specular_prior * kernels::cost_unit));
  cost_.resize(static_cast<std::size_t>(grid.sweepRows() + kernels::overrun));
}

void SpecularCost::apply(const CurrentView& current, const VerticalSweep& sweep,
                         const SweepReference& reference, double turned,
                         ImageView<std::uint16_t> floor_cost) {
  // the floor at r moves by ln(1 + r b / h) over a baseline b along the line
  const double baseline = std::hypot(reference.motion.tx, reference.motion.ty);
  const double least_r = std::expm1(parallax_) * grid_.height / std::max(baseline, 1e-6);
  const double fine_row = (std::log(least_r) - grid_.log_r_far) * grid_.rows_per_log;
  const int first_row =
      static_cast<int>(std::clamp(fine_row / PolarGrid::rows_per_sweep_row, 0.0, 1e6));
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const double place = sweep.firstLine(beam) - turned * grid_.lines_per_radian;
    const double line = std::floor(place);
    if (!(line >= 0.0 && line < static_cast<double>(reference_rows_.size()))) continue;
    const int first = static_cast<int>(line);
    const RowRange seen = reference.seen(static_cast<std::size_t>(first), reference_rows_);
    const RowRange rows =
        intersection({std::max(sweep.rows(beam).begin, first_row), sweep.rows(beam).end},
                     {(seen.begin + 1) / 2, (seen.end - 1) / 2});
    if (rows.size() == 0) continue;
    kernels::VerticalPath path;
    path.current = current.grey.row(sweep.firstLine(beam)) + rows.begin;
    path.weight = current.weight.row(sweep.firstLine(beam)) + rows.begin;
    path.stride = grid_.sweepRows();
    path.upper = reference.even.row(first) + rows.begin;
    path.lower = reference.odd.row(first) + rows.begin;
    path.line_fraction = static_cast<std::int16_t>((place - line) * 32767.0);
    kernels::verticalCost(path, rows.size(), cost_.data());
    kernels::lowerTo(cost_.data(), prior_, rows.size(), floor_cost.row(beam) + rows.begin);
  }
}

}  // namespace ipm_mapping::sweep
