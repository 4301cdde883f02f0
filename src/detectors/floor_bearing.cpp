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

/// Rows of a line from `lowest` up to where its floor leaves the range. The distance to the base
/// origin is a convex function along a ray from the camera's foot: it leaves the range once.
int highestRowInRange(const std::int16_t* column, int first, int lowest, const FloorOfView& floor,
                      double max_range) {
  const auto inside = [&](int v) {
    const auto point = floor.at(column[v], v);
    return point && point->norm() <= max_range;
  };
  if (!inside(lowest)) return lowest + 1;
  int in = lowest, out = first - 1;
  while (in - out > 1) {
    const int middle = (in + out) / 2;
    (inside(middle) ? in : out) = middle;
  }
  return in;
}

Stretch measure(const LineOnMask& line, const FloorOfView& floor, double max_range) {
  const std::int16_t* column = line.columns;
  Stretch stretch;
  int lowest = line.height - 1, first = 0;
  while (lowest >= 0 && column[lowest] == PolarBeam::outside) --lowest;
  while (first < lowest && column[first] == PolarBeam::outside) ++first;
  if (lowest < 0) return stretch;
  const int highest = highestRowInRange(column, first, lowest, floor, max_range);
  int near = -1, far = -1;
  bool broken = false;
  for (int v = lowest; v >= highest; --v) {
    if (line.values[v] == mask::unseen) {
      broken = near >= 0;
      continue;
    }
    if (near < 0) near = v;
    if (!broken) far = v;
    ++stretch.seen;
  }
  stretch.rows = lowest - highest + 1;
  if (near < 0) return stretch;
  stretch.near = (*floor.at(column[near], near) - floor.foot).norm();
  stretch.far_point = *floor.at(column[far], far);
  stretch.far = (stretch.far_point - floor.foot).norm();
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
  for (int v = line.height - 1; v >= 0; --v) {
    const bool in_picture = line.columns[v] != PolarBeam::outside;
    run = in_picture && line.values[v] == mask::obstacle ? run + 1 : 0;
    if (run == min_pixels) return v + min_pixels - 1;
  }
  return -1;
}

}  // namespace ipm_mapping
