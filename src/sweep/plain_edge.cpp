#include "ipm_mapping/sweep/plain_edge.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ipm_mapping::sweep {

void PlainEdge::configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                          const FootParameters& parameters) {
  support_rows_ = static_cast<int>(std::lround(sweep.scoreGrid().rowsUp(parameters.foot_support)));
  doubt_ = static_cast<float>(parameters.foot_doubt);
  least_step_ = static_cast<std::int32_t>(
      std::lround(2.0 * kernels::beam_lines * kernels::grey_unit * free_floor.free_edge));
  int last_row = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam)
    last_row = std::max(last_row, sweep.rows(beam).end);
  profile_.resize(static_cast<std::size_t>(last_row));
}

bool PlainEdge::mayStand(const SweepReference* references, int count, VerticalSweep& sweep,
                         int beam, int candidate) const {
  const int row = static_cast<int>(sweep.sweepRow(candidate));
  return sweep.evidence(references, count, beam, candidate,
                        {row - support_rows_, row - edge_rows + 1}) >= -doubt_;
}

void PlainEdge::fillProfile(const CurrentView& current, int first_line) {
  std::fill(profile_.begin(), profile_.end(), 0);
  for (int line = first_line; line < first_line + kernels::beam_lines; ++line) {
    const std::int16_t* grey = current.grey.row(line);
    for (std::size_t row = 0; row < profile_.size(); ++row) profile_[row] += grey[row];
  }
}

int PlainEdge::nearest(const CurrentView& current, const SweepReference* references, int count,
                       VerticalSweep& sweep, int beam, double range) {
  fillProfile(current, sweep.firstLine(beam));
  const auto step = [&](int row) {
    const auto j = static_cast<std::size_t>(row);
    return std::abs(profile_[j + 1] - profile_[j - 1]);
  };
  const RowRange seen = sweep.rows(beam);
  const int first_row = static_cast<int>(sweep.sweepRow(0.0));
  bool aimed = false;
  for (int row = seen.end - 3; row >= std::max(first_row, seen.begin + 2); --row) {
    const std::int32_t here = step(row);
    if (here < least_step_ || here < step(row - 1) || here < step(row + 1)) continue;
    const int candidate = row - first_row;
    if (sweep.distance(candidate) >= range) break;
    if (!aimed) sweep.aimBeam(current, references, count, beam);
    aimed = true;
    if (mayStand(references, count, sweep, beam, candidate)) return candidate;
  }
  return -1;
}

double PlainEdge::limit(const CurrentView& current, const SweepReference* references, int count,
                        VerticalSweep& sweep, int beam, double range) {
  const int candidate = nearest(current, references, count, sweep, beam, range);
  return candidate < 0 ? range : sweep.distance(candidate);
}

}  // namespace ipm_mapping::sweep
