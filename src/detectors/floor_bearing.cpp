#include "ipm_mapping/detectors/floor_bearing.hpp"

#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "ipm_mapping/stages/polar_histogram.hpp"

namespace ipm_mapping {
namespace {

/// The stretch of floor that one line sees within the range that is looked at.
struct Stretch {
  int rows = 0;       ///< rows on the floor within range
  int seen = 0;       ///< of these, seen by both frames
  double near = 0.0;  ///< metres from the foot: lowest seen row
  double far = 0.0;   ///< highest row of the unbroken run that starts there
  Eigen::Vector2d far_point{1.0, 0.0};
};

Stretch measure(const LineOnMask& line, const FloorOfView& floor, double max_range) {
  Stretch stretch;
  bool broken = false;
  for (int v = line.obstacle_mask.height - 1; v >= 0; --v) {
    const int u = line.columns[v];
    if (u == PolarBeam::outside) continue;
    const auto point = floor.at(u, v);
    if (!point || point->norm() > max_range) break;
    ++stretch.rows;
    if (line.obstacle_mask.at(u, v) == mask::unseen) {
      broken = broken || stretch.seen > 0;
      continue;
    }
    const double distance = (*point - floor.foot).norm();
    if (stretch.seen++ == 0) stretch.near = distance;
    if (broken) continue;
    stretch.far = distance;
    stretch.far_point = *point;
  }
  return stretch;
}

}  // namespace

Bearing floorBearing(const LineOnMask& line, const FloorOfView& floor, double max_range,
                     double min_floor_share, float density, const std::optional<LineStop>& stop) {
  const Stretch stretch = measure(line, floor, max_range);
  Bearing bearing;
  bearing.angle = floor.angle(stretch.far_point);
  bearing.near = static_cast<float>(stretch.near);
  bearing.range = static_cast<float>(stretch.far);
  bearing.density = density;
  if (stretch.seen > 0 && stretch.seen >= min_floor_share * stretch.rows)
    bearing.state = BearingState::Free;
  if (!stop) return bearing;
  const auto p = floor.at(stop->u, stop->v);
  if (!p || p->norm() > max_range) return bearing;
  bearing.angle = floor.angle(*p);
  bearing.range = static_cast<float>((*p - floor.foot).norm());
  bearing.state = stop->state;
  return bearing;
}

int lowestRun(const LineOnMask& line, int min_pixels) {
  int run = 0;
  for (int v = line.obstacle_mask.height - 1; v >= 0; --v) {
    const int u = line.columns[v];
    const bool obstacle = u != PolarBeam::outside && line.obstacle_mask.at(u, v) == mask::obstacle;
    run = obstacle ? run + 1 : 0;
    if (run == min_pixels) return v + min_pixels - 1;
  }
  return -1;
}

}  // namespace ipm_mapping
