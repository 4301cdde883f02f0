#include "ipm_mapping/sweep/rolling_shutter.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/sway_line.hpp"
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
  times_ = &rectification.readTimes();
  seen_ = rectification.ranges();
  foot_ = camera_foot;
  longest_ = std::abs(longest);
  beside_ = static_cast<int>(std::ceil(half * longest_ * fastest_turn * grid_.lines_per_radian));
  rows_ = seen_;
  if (beside_ > 0) {
    const std::vector<RowRange> shared = commonRows(seen_, 2 * beside_ + 1);
    rows_.assign(seen_.size(), {});
    for (std::size_t i = 0; i < shared.size(); ++i)
      rows_[i + static_cast<std::size_t>(beside_)] = shared[i];
  }
  const auto padded = static_cast<std::size_t>(grid_.rows + kernels::overrun);
  nearness_.assign(padded, 0.0F);
  for (int row = 0; row < grid_.rows; ++row)
    nearness_[static_cast<std::size_t>(row)] = static_cast<float>(1.0 / grid_.distance(row));
  along_.assign(padded, 0.0F);
  across_.assign(padded, 0.0F);
}

bool RollingShutter::matters(const Velocity& velocity, double readout) const {
  if (readout == 0.0 || grid_.rows == 0) return false;
  const Velocity foot = ofFoot(velocity, foot_);
  const double time = half * std::abs(readout), nearest = grid_.distance(grid_.rows - 1);
  const double turn = std::abs(foot.theta) + std::abs(foot.y) / nearest;
  const double way = std::hypot(foot.x, foot.y) / nearest;
  return time * std::max(turn * grid_.lines_per_radian, way * grid_.rows_per_log) > least_shift;
}

/// Where the rows of a line are found, rows and lines away.
void RollingShutter::shiftsOf(int line, const Velocity& foot, double readout) {
  const double azimuth = grid_.azimuth(line), c = std::cos(azimuth), s = std::sin(azimuth);
  const auto turn = static_cast<float>(grid_.lines_per_radian * readout * foot.theta);
  const auto aside =
      static_cast<float>(grid_.lines_per_radian * readout * (c * foot.y - s * foot.x));
  const auto ahead = static_cast<float>(grid_.rows_per_log * readout * (c * foot.x + s * foot.y));
  const auto most = static_cast<float>(beside_);
  const float* times = times_->row(line);
  const RowRange rows = seen_[static_cast<std::size_t>(line)];
  for (int row = rows.begin; row < rows.end; ++row) {
    const auto j = static_cast<std::size_t>(row);
    along_[j] = times[row] * nearness_[j] * ahead;
    across_[j] = std::clamp(times[row] * (turn + nearness_[j] * aside), -most, most);
  }
}

void RollingShutter::undo(const Velocity& velocity, double readout,
                          const Image<std::uint8_t>& image, Image<std::uint8_t>& out) {
  const Velocity foot = ofFoot(velocity, foot_);
  for (int line = 0; line < grid_.lines; ++line) {
    const RowRange rows = seen_[static_cast<std::size_t>(line)];
    if (rows.size() < 2) continue;
    shiftsOf(line, foot, readout);
    kernels::swayLine(image.view(), line, {along_.data(), across_.data(), 1.0F, 1.0F}, rows.begin,
                      rows.end, out.row(line));
  }
}

}  // namespace ipm_mapping::sweep
