#include "ipm_mapping/sweep/floor_cost.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/floor_residual.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/kernels/sweep_rectify.hpp"
#include "ipm_mapping/kernels/sweep_sums.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int block = 8;               // rows and lines between exact positions
constexpr float node_unit = 1024.0F;   // of positions at nodes
constexpr double fixed_one = 16384.0;  // of gain and offset
constexpr double least_gain = 0.5, most_gain = 1.5;
constexpr double most_offset = 64.0;              // grey levels
constexpr double node_reach = 0.3;                // radians that nodes may lie beside the view
constexpr std::int32_t out_of_view = -(1 << 26);  // nothing between it and the view is seen

}  // namespace

bool Photometric::withinBounds() const {
  return gain >= least_gain && gain <= most_gain && std::abs(offset) <= most_offset;
}

std::int32_t Photometric::fixedGain() const {
  return static_cast<std::int32_t>(
      std::lround(fixed_one * std::clamp(gain, least_gain, most_gain)));
}

std::int32_t Photometric::fixedOffset() const {
  return static_cast<std::int32_t>(
      std::lround(fixed_one * std::clamp(offset, -most_offset, most_offset)));
}

void FloorCost::configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                          const EvidenceParameters& p) {
  grid_ = grid;
  reference_rows_ = reference_rows;
  beam_step_ = p.beam_step;
  half_lines_ = static_cast<int>(std::lround(0.5 * p.drift_width * grid.lines_per_radian));
  half_rows_ = static_cast<int>(
      std::lround(0.5 * p.drift_length * grid.rows_per_log / PolarGrid::rows_per_sweep_row));
  const int rows = grid.sweepRows();
  node_rows_ = (rows + block - 1) / block + 1;
  node_lines_ = (grid.lines + block - 1) / block + 1;
  row_nodes_.resize(node_rows_, node_lines_);
  line_nodes_.resize(node_rows_, node_lines_);
  inverse_distance_.assign(static_cast<std::size_t>(node_rows_ + kernels::overrun), 1.0F);
  for (int k = 0; k < node_rows_; ++k)
    inverse_distance_[static_cast<std::size_t>(k)] =
        static_cast<float>(1.0 / grid.distance(k * block * PolarGrid::rows_per_sweep_row));
  line_position_.resize(inverse_distance_.size());
  row_position_.resize(inverse_distance_.size());
  rows_here_.resize(static_cast<std::size_t>(node_rows_));
  lines_here_.resize(static_cast<std::size_t>(node_rows_));
  row_path_.resize(static_cast<std::size_t>(node_rows_ * block));
  line_path_.resize(static_cast<std::size_t>(node_rows_ * block));
  pairs_.resize(grid.rows, grid.lines);
  compared_.assign(static_cast<std::size_t>(grid.lines), {});
  residual_.resize(rows, grid.lines, kernels::no_residual);
  const auto n = static_cast<std::size_t>(rows + kernels::overrun);
  sum_.resize(n + static_cast<std::size_t>(2 * half_rows_));
  number_.resize(sum_.size());
  sum_before_.resize(sum_.size() + 1);
  number_before_.resize(sum_before_.size());
  mean_.resize(n);
  squares_.resize(n);
}

/// Exact reference positions of the floor on a coarse lattice of rows and lines. Where they run
/// around the reference's foot, or wrap around behind it, nothing lies between two of them.
void FloorCost::buildNodes(const FootMotion& motion) {
  const auto reach = static_cast<float>(node_reach * grid_.lines_per_radian);
  for (int l = 0; l < node_lines_; ++l) {
    const kernels::FloorRay ray = floorRay(grid_, motion, grid_.azimuth(l * block));
    kernels::rayPositions(ray, inverse_distance_.data(), node_rows_, line_position_.data(),
                          row_position_.data());
    for (int k = 0; k < node_rows_; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const auto row = static_cast<float>(k * block * PolarGrid::rows_per_sweep_row);
      row_nodes_.at(k, l) = static_cast<std::int32_t>(node_unit * (row + row_position_[i]));
      const float line = line_position_[i];
      const bool beside = line < -reach || line > static_cast<float>(grid_.lines) + reach;
      line_nodes_.at(k, l) = beside ? out_of_view : static_cast<std::int32_t>(node_unit * line);
    }
  }
}

/// Positions at the nodes of one line, between those of the two node lines beside it.
void FloorCost::nodesOf(int line) {
  const int l = line / block, t = line % block;
  kernels::blendNodes(row_nodes_.row(l), row_nodes_.row(l + 1), t, node_rows_, rows_here_.data());
  kernels::blendNodes(line_nodes_.row(l), line_nodes_.row(l + 1), t, node_rows_,
                      lines_here_.data());
  kernels::interpolateNodes(rows_here_.data(), node_rows_ - 1, row_path_.data());
  kernels::interpolateNodes(lines_here_.data(), node_rows_ - 1, line_path_.data());
}

/// Shrinks a run of rows of a line until its ends are seen by the reference too. What a reference
/// sees of the floor is convex, so nothing is missing in between.
RowRange FloorCost::seenInBoth(const std::vector<RowRange>& reference, RowRange rows) const {
  const auto seen = [&](int j) {
    const auto i = static_cast<std::size_t>(j);
    const std::int32_t l = line_path_[i] >> 6, r = row_path_[i] >> 6;
    if (line_path_[i] < 0 || l + 1 >= grid_.lines) return false;
    const RowRange a = reference[static_cast<std::size_t>(l)];
    const RowRange b = reference[static_cast<std::size_t>(l) + 1];
    const RowRange both = intersection(a, b);
    return r >= both.begin && r + 1 < both.end;
  };
  while (rows.size() > 0 && !seen(rows.begin)) ++rows.begin;
  while (rows.size() > 0 && !seen(rows.end - 1)) --rows.end;
  return rows;
}

/// The residual of every line, and on which rows there is one.
void FloorCost::compare(const CurrentView& current, const Photometric& photometric,
                        const std::vector<RowRange>& reference_rows) {
  for (int line = 0; line < grid_.lines; ++line) {
    const auto i = static_cast<std::size_t>(line);
    std::int16_t* out = residual_.row(line);
    std::fill(out, out + grid_.sweepRows(), kernels::no_residual);
    compared_[i] = (*current.rows)[i];
    if (compared_[i].size() == 0) continue;
    nodesOf(line);
    compared_[i] = seenInBoth(reference_rows, compared_[i]);
    const int begin = compared_[i].begin;
    kernels::pathResidual(pairs_.view(), row_path_.data() + begin, line_path_.data() + begin,
                          photometric.fixedGain(), photometric.fixedOffset(),
                          current.grey.row(line) + begin, compared_[i].size(), out + begin);
  }
}

/// Takes a line into the sums that means are made of, or out of them again.
void FloorCost::accumulate(int line, int sign) {
  if (line < 0 || line >= grid_.lines) return;
  const RowRange rows = compared_[static_cast<std::size_t>(line)];
  kernels::accumulateResidual(residual_.row(line) + rows.begin, sign, rows.size(),
                              sum_.data() + half_rows_ + rows.begin,
                              number_.data() + half_rows_ + rows.begin);
}

/// t^2 of a line's rows, with the mean residual around each of them as what may drift.
void FloorCost::squaresOf(const CurrentView& current, int line) {
  const RowRange rows = compared_[static_cast<std::size_t>(line)];
  const int width = 2 * half_rows_ + 1, reached = rows.size() + width - 1;
  kernels::prefixSums(sum_.data() + rows.begin, reached, sum_before_.data());
  kernels::prefixSums(number_.data() + rows.begin, reached, number_before_.data());
  kernels::windowMean(sum_before_.data(), number_before_.data(), width, rows.size(),
                      mean_.data() + rows.begin);
  kernels::squaredFloorDeviation(residual_.row(line) + rows.begin, mean_.data() + rows.begin,
                                 current.weight.row(line) + rows.begin, rows.size(),
                                 squares_.data() + rows.begin);
}

/// Rows on which all lines of a beam were compared.
RowRange FloorCost::comparedByAll(int beam) const {
  const auto first = static_cast<std::size_t>(beam * beam_step_);
  RowRange rows = compared_[first];
  for (std::size_t line = first + 1; line < first + kernels::beam_lines; ++line)
    rows = intersection(rows, compared_[line]);
  return rows;
}

void FloorCost::evaluate(const CurrentView& current, ImageView<const std::uint8_t> reference,
                         const FootMotion& motion, const Photometric& photometric,
                         ImageView<std::uint16_t> cost,
                         const std::vector<RowRange>* reference_rows) {
  kernels::pairRows(reference, pairs_.view());
  buildNodes(motion);
  compare(current, photometric, reference_rows != nullptr ? *reference_rows : reference_rows_);
  std::fill(cost.data, cost.row(cost.height), kernels::no_cost);
  for (int beam = 0; beam < cost.height; ++beam) {
    const RowRange rows = comparedByAll(beam);
    std::fill_n(cost.row(beam) + rows.begin, rows.size(), std::uint16_t{0});
  }
  std::fill(sum_.begin(), sum_.end(), 0);
  std::fill(number_.begin(), number_.end(), 0);
  for (int line = 0; line < half_lines_; ++line) accumulate(line, 1);
  for (int line = 0; line < grid_.lines; ++line) {
    accumulate(line + half_lines_, 1);
    accumulate(line - half_lines_ - 1, -1);
    squaresOf(current, line);
    const int last = std::min(line / beam_step_, cost.height - 1);
    const int first = std::max(0, (line - kernels::beam_lines + beam_step_) / beam_step_);
    for (int beam = first; beam <= last; ++beam) {
      const RowRange rows = comparedByAll(beam);
      kernels::addSquares(squares_.data() + rows.begin, rows.size(), cost.row(beam) + rows.begin);
    }
  }
}

}  // namespace ipm_mapping::sweep
