// Floor points of the current frame and where the reference sees them.
#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/motion_refinement.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int margin = 3;  // rows that a sample keeps from the edge of the view

}  // namespace

void MotionRefinement::configure(const PolarGrid& grid, const std::vector<RowRange>& rows,
                                 const Eigen::Vector2d& camera_foot,
                                 const MotionRefinementParameters& parameters) {
  grid_ = grid;
  rows_ = rows;
  foot_ = camera_foot;
  parameters_ = parameters;
  points_.clear();
  x_.clear();
  y_.clear();
  floor_begin_.assign(static_cast<std::size_t>(grid.lines), 0);
  const int first = std::max(0, static_cast<int>(grid.row(grid.height * parameters.farthest)));
  for (int line = 1; line < grid.lines - 1; line += parameters.line_step) {
    const RowRange range = rows[static_cast<std::size_t>(line)];
    for (int row = std::max(first, range.begin); row < range.end; row += parameters.row_step) {
      const double azimuth = grid.azimuth(line), distance = grid.distance(row);
      points_.push_back({row, line});
      x_.push_back(static_cast<float>(distance * std::cos(azimuth)));
      y_.push_back(static_cast<float>(distance * std::sin(azimuth)));
    }
  }
  x_.resize(points_.size() + kernels::overrun);
  y_.resize(x_.size());
  samples_.resize(x_.size());
}

void MotionRefinement::Samples::resize(std::size_t n) {
  for (auto* array :
       {&row, &line, &current, &current_high, &reference_mean, &warped, &warped_high, &deviation})
    array->assign(n, 0.0F);
  seen_row.assign(n, 0);
  seen_line.assign(n, 0);
  for (auto* arrays : {&d_row, &d_line, &gradient})
    for (auto& array : *arrays) array.assign(n, 0.0F);
}

void MotionRefinement::Samples::move(std::size_t from, std::size_t to) {
  row[to] = row[from];
  line[to] = line[from];
  for (std::size_t k = 0; k < d_row.size(); ++k) {
    d_row[k][to] = d_row[k][from];
    d_line[k][to] = d_line[k][from];
  }
}

kernels::SamplePositions MotionRefinement::Samples::positions() {
  kernels::SamplePositions all;
  all.row = row.data();
  all.line = line.data();
  for (std::size_t k = 0; k < d_row.size(); ++k) {
    all.d_row[k] = d_row[k].data();
    all.d_line[k] = d_line[k].data();
  }
  return all;
}

/// Is what is seen around a position of the reference well inside its view?
bool MotionRefinement::inView(float row, float line) const {
  if (!(line >= 1.0F && line < static_cast<float>(grid_.lines - 3))) return false;
  const RowRange range = intersection(rows_[static_cast<std::size_t>(line)],
                                      rows_[static_cast<std::size_t>(line) + 1]);
  return row >= static_cast<float>(range.begin + margin) &&
         row < static_cast<float>(range.end - margin - 1);
}

/// Where the floor points are seen in the reference, and how that moves with the motion; what both
/// frames see becomes the samples.
void MotionRefinement::linearize(const RectifiedFrame& current, const RectifiedFrame& reference,
                                 const SE2& motion) {
  kernels::projectFloor(x_.data(), y_.data(), static_cast<int>(points_.size()), projection(motion),
                        samples_.positions());
  std::size_t n = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const FloorPoint& point = points_[i];
    if (point.row < floor_begin_[static_cast<std::size_t>(point.line)]) continue;
    if (!inView(samples_.row[i], samples_.line[i])) continue;
    samples_.move(i, n);
    samples_.seen_row[n] = point.row;
    samples_.seen_line[n] = point.line;
    samples_.reference_mean[n] = reference.mean.at(samples_.row[n], samples_.line[n]);
    samples_.current[n] = static_cast<float>(current.image.at(point.row, point.line));
    samples_.current_high[n] =
        samples_.current[n] -
        current.mean.at(static_cast<float>(point.row), static_cast<float>(point.line));
    ++n;
  }
  samples_.count = static_cast<int>(n);
}

kernels::FloorProjection MotionRefinement::projection(const SE2& motion) const {
  const FootMotion foot(motion, foot_);
  kernels::FloorProjection p;
  p.c = static_cast<float>(foot.c);
  p.s = static_cast<float>(foot.s);
  p.tx = static_cast<float>(foot.tx);
  p.ty = static_cast<float>(foot.ty);
  p.foot_x = static_cast<float>(foot_.x());
  p.foot_y = static_cast<float>(foot_.y());
  p.height = static_cast<float>(grid_.height);
  p.rows_per_log = static_cast<float>(grid_.rows_per_log);
  p.row_at_one = static_cast<float>(grid_.row(1.0));
  p.lines_per_radian = static_cast<float>(grid_.lines_per_radian);
  p.line_ahead = static_cast<float>(grid_.line(0.0));
  return p;
}

void MotionRefinement::warp(const RectifiedFrame& reference, const Correction& correction) {
  const Eigen::Matrix<float, kernels::alignment_moves, 1> c = correction.cast<float>();
  kernels::WarpedSamples out;
  out.grey = samples_.warped.data();
  out.high = samples_.warped_high.data();
  for (std::size_t k = 0; k < samples_.gradient.size(); ++k)
    out.gradient[k] = samples_.gradient[k].data();
  kernels::warpSamples(reference.image.view(), samples_.positions(), samples_.reference_mean.data(),
                       c.data(), samples_.count, out);
}

FloorSamples MotionRefinement::floor(const RefinedMotion& motion) {
  const auto gain = static_cast<float>(motion.photometric.gain);
  const auto offset = static_cast<float>(motion.photometric.offset);
  for (int i = 0; i < samples_.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    samples_.deviation[k] = gain * samples_.warped[k] + offset;
  }
  return {samples_.current.data(),  samples_.deviation.data(),
          samples_.seen_row.data(), samples_.seen_line.data(),
          samples_.row.data(),      samples_.line.data(),
          samples_.count,           motion.sigma};
}

}  // namespace ipm_mapping::sweep
