#include "ipm_mapping/ros/scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace ipm_mapping {
namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// Amcl takes a range at or below range_min for "nothing there": no contact may fall under it.
constexpr float range_min = 0.01F;
/// Length of floor that two rows of the picture cover at `range` from the camera's foot: floor that
/// ends that much short of range_max was seen up to the last row in front of it.
double twoRows(const GroundView& view, double range) {
  const double h = view.cameraHeight(), f = view.camera.intrinsics().fy;
  return h > 0.0 && f > 0.0 ? 2.0 * (range * range + h * h) / (h * f) : 0.0;
}

/// A sector of angles around the foot of the camera.
struct Sector {
  double low, high;
};

/// Angles that are nearer to bearing i than to its neighbours.
Sector sectorOf(const std::vector<Bearing>& bearings, std::size_t i) {
  const double here = bearings[i].angle;
  const auto half = [&](std::size_t j) {
    return 0.5 * std::abs(wrapAngle(double{bearings[j].angle} - here));
  };
  const bool first = i == 0, last = i + 1 == bearings.size();
  if (first && last) return {here - 1e-3, here + 1e-3};
  const double left = half(first ? i + 1 : i - 1);
  const double right = half(last ? i - 1 : i + 1);
  return {here - right, here + left};
}

/// Point at `range` from the foot of the camera, in base.
Eigen::Vector2d pointAt(const Obstacles& obstacles, double angle, double range) {
  return obstacles.view.cameraFoot() + range * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// What the bearings have said about one cell of the scan.
struct ScanCell {
  float range = inf;
  bool seen = false;    ///< a bearing saw floor up to range_max
  bool hidden = false;  ///< a bearing did not
};

/// Spreads bearings over a uniform grid of angles around the base origin.
class ScanGrid {
 public:
  ScanGrid(const Obstacles& obstacles, double range_max)
      : obstacles_(obstacles),
        range_max_(range_max),
        tolerance_(std::max(1e-3, twoRows(obstacles.view, range_max))),
        middle_(obstacles.bearings[obstacles.bearings.size() / 2].angle),
        cells_(obstacles.bearings.size()) {
    cover();
    for (std::size_t i = 0; i < cells_.size(); ++i) add(i);
  }

  void write(sensor_msgs::LaserScan& scan) const {
    scan.angle_min = static_cast<float>(middle_ + low_ + 0.5 * increment_);
    scan.angle_increment = static_cast<float>(increment_);
    scan.angle_max = scan.angle_min + scan.angle_increment * static_cast<float>(cells_.size() - 1);
    scan.ranges.resize(cells_.size());
    std::transform(cells_.begin(), cells_.end(), scan.ranges.begin(), [](const ScanCell& cell) {
      return cell.range < inf ? cell.range : cell.seen && !cell.hidden ? inf : nan;
    });
  }

 private:
  [[nodiscard]] static bool known(const Bearing& bearing) {
    return bearing.state != BearingState::Unknown && std::isfinite(bearing.range);
  }
  /// Angle around the base origin, counted from the middle bearing: no wrap inside the view.
  [[nodiscard]] double angleAt(double bearing_angle, double range) const {
    const Eigen::Vector2d p = pointAt(obstacles_, bearing_angle, range);
    return wrapAngle(std::atan2(p.y(), p.x()) - middle_);
  }

  /// Chooses the grid so that it holds the view at range_max and every contact.
  void cover() {
    double low = inf, high = -inf;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const Bearing& bearing = obstacles_.bearings[i];
      const Sector sector = sectorOf(obstacles_.bearings, i);
      const double nearest =
          known(bearing) ? std::min<double>(bearing.range, range_max_) : range_max_;
      for (double edge : {sector.low, sector.high})
        for (double range : {nearest, range_max_}) {
          low = std::min(low, angleAt(edge, range));
          high = std::max(high, angleAt(edge, range));
        }
    }
    low_ = low;
    increment_ = (high - low) / static_cast<double>(cells_.size());
  }

  void add(std::size_t i) {
    const Bearing& bearing = obstacles_.bearings[i];
    const Sector sector = sectorOf(obstacles_.bearings, i);
    const double range = known(bearing) ? bearing.range : 0.0;
    const double end = pointAt(obstacles_, bearing.angle, range).norm();
    const bool reaches = known(bearing) && end >= range_max_ - tolerance_;
    forCells(sector, range_max_,
             [reaches](ScanCell& cell) { (reaches ? cell.seen : cell.hidden) = true; });
    const float published = std::max(static_cast<float>(end), 2.0F * range_min);
    if (bearing.state != BearingState::Occupied || !known(bearing) ||
        published >= static_cast<float>(range_max_))
      return;
    forCells(sector, range,
             [published](ScanCell& cell) { cell.range = std::min(cell.range, published); });
  }

  /// Cells of which the sector, seen from the base origin at `range`, fills more than a quarter; at
  /// least the one under its middle.
  template <class Use>
  void forCells(const Sector& sector, double range, Use&& use) {
    const double a = (angleAt(sector.low, range) - low_) / increment_;
    const double b = (angleAt(sector.high, range) - low_) / increment_;
    double from = std::floor(std::min(a, b) + 0.25), to = std::floor(std::max(a, b) - 0.25);
    if (to < from) from = to = std::floor(0.5 * (a + b));
    const double last = static_cast<double>(cells_.size()) - 1.0;
    for (double i = std::max(from, 0.0); i <= std::min(to, last); ++i)
      use(cells_[static_cast<std::size_t>(i)]);
  }

  const Obstacles& obstacles_;
  double range_max_;
  double tolerance_;  ///< metres
  double middle_;
  double low_ = 0.0, increment_ = 1.0;
  std::vector<ScanCell> cells_;
};

double scanRangeMax(const Obstacles& obstacles, const OutputParameters& parameters) {
  const double looked_at = obstacles.max_range;
  return parameters.scan_range_max > 0.0 ? std::min(parameters.scan_range_max, looked_at)
                                         : looked_at;
}

}  // namespace

void toScan(const Obstacles& obstacles, const OutputParameters& parameters,
            sensor_msgs::LaserScan& scan) {
  const double range_max = scanRangeMax(obstacles, parameters);
  scan.range_min = range_min;
  scan.range_max = static_cast<float>(range_max);
  scan.time_increment = 0.0F;
  scan.scan_time = 0.0F;
  scan.intensities.clear();
  scan.ranges.clear();
  if (obstacles.bearings.empty()) return;
  ScanGrid(obstacles, range_max).write(scan);
}

}  // namespace ipm_mapping
