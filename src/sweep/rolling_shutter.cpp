#include "ipm_mapping/sweep/rolling_shutter.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double least_shift = 0.2;  // lines or rows
constexpr double half = 0.5;         // of the readout is the farthest from the stamp

/// Of the camera's foot, in the robot's axes.
Velocity ofFoot(const Velocity& base, const Eigen::Vector2d& foot) {
  return {base.x - base.theta * foot.y(), base.y + base.theta * foot.x(), base.theta};
}

}  // namespace

void RollingShutter::configure(const CylindricalRectification& rectification,
                               const Eigen::Vector2d& camera_foot, double longest) {
  grid_ = rectification.grid();
  foot_ = camera_foot;
  longest_ = std::abs(longest);
  beside_ = static_cast<int>(std::ceil(half * longest_ * fastest_turn * grid_.lines_per_radian));
  rows_ = rectification.ranges();
  below_ = 0;
  if (beside_ > 0) {
    below_ = static_cast<int>(std::ceil(half * longest_ * fastest_way * grid_.rows_per_log /
                                        grid_.distance(grid_.rows - 1)));
    const std::vector<RowRange> shared = commonRows(rows_, 2 * beside_ + 1);
    rows_.assign(rows_.size(), {});
    for (std::size_t i = 0; i < shared.size(); ++i) {
      const RowRange spared{shared[i].begin + 1, shared[i].end - 1 - below_};
      if (spared.size() > 0) rows_[i + static_cast<std::size_t>(beside_)] = spared;
    }
  }
  const auto padded = static_cast<std::size_t>(grid_.rows + kernels::overrun);
  nearness_.assign(padded, 0.0F);
  for (int row = 0; row < grid_.rows; ++row)
    nearness_[static_cast<std::size_t>(row)] = static_cast<float>(1.0 / grid_.distance(row));
}

RollingShutter::Shift RollingShutter::most(const Velocity& velocity, double readout) const {
  const Velocity foot = ofFoot(velocity, foot_);
  const double time = half * std::abs(readout), nearest = grid_.distance(grid_.rows - 1);
  const double way = std::hypot(foot.x, foot.y) / nearest;
  return {time * (std::abs(foot.theta) + std::abs(foot.y) / nearest) * grid_.lines_per_radian,
          time * way * grid_.rows_per_log};
}

bool RollingShutter::matters(const Velocity& velocity, double readout) const {
  if (readout == 0.0 || grid_.rows == 0) return false;
  const Shift shift = most(velocity, readout);
  return std::max(shift.lines, shift.rows) > least_shift;
}

bool RollingShutter::reaches(const Velocity& velocity, double readout) const {
  const Shift shift = most(velocity, readout);
  return shift.lines <= beside_ + least_shift && shift.rows <= below_ + 1.0;
}

void RollingShutter::blankOutside(Image<std::uint8_t>& image) const {
  for (int line = 0; line < grid_.lines; ++line) {
    const RowRange rows = rows_[static_cast<std::size_t>(line)];
    std::uint8_t* pixels = image.row(line);
    std::fill(pixels, pixels + rows.begin, std::uint8_t{0});
    std::fill(pixels + std::max(rows.begin, rows.end), pixels + grid_.rows, std::uint8_t{0});
  }
}

kernels::MovedRows RollingShutter::moved(int line, const Velocity& foot, double readout) const {
  const double azimuth = grid_.azimuth(line), c = std::cos(azimuth), s = std::sin(azimuth);
  const double lines = grid_.lines_per_radian * readout, rows = grid_.rows_per_log * readout;
  kernels::MovedRows m;
  m.nearness = nearness_.data();
  m.ahead = static_cast<float>(rows * (c * foot.x + s * foot.y));
  m.turn = static_cast<float>(lines * foot.theta);
  m.aside = static_cast<float>(lines * (c * foot.y - s * foot.x));
  m.most = static_cast<float>(beside_);
  m.most_rows = static_cast<float>(below_ + 1);
  return m;
}

void RollingShutter::rectify(CylindricalRectification& rectification, GrayView raw,
                             const Velocity& velocity, double readout,
                             ImageView<std::uint8_t> rectified) {
  const Velocity foot = ofFoot(velocity, foot_);
  rectification.load(raw);
  for (int line = 0; line < grid_.lines; ++line) {
    const RowRange rows = rows_[static_cast<std::size_t>(line)];
    if (rows.size() > 0)
      rectification.sampleMoved(line, rows, moved(line, foot, readout), rectified.row(line));
  }
}

}  // namespace ipm_mapping::sweep
