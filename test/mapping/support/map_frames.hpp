#pragma once

#include <cmath>
#include <limits>
#include <random>

#include "ipm_mapping/mapping/occupancy_map.hpp"

namespace ipm_mapping::map_test {

inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// A frame of a robot at `pose` whose camera stands over (camera_x, 0) of base.
inline Obstacles frameAt(const SE2& pose, double camera_x = 0.0) {
  Obstacles frame;
  frame.view.T_odom_base = pose;
  frame.view.T_base_camera = cameraPose(camera_x, 0.0, 0.45, 0.42);
  return frame;
}

inline Bearing bearing(BearingState state, float angle, float range, float near = 0.0F) {
  Bearing b;
  b.state = state;
  b.angle = angle;
  b.range = range;
  b.near = near;
  return b;
}

inline Contact contactAt(float x, float y, float range_sigma = 0.0F) {
  Contact c;
  c.p_base = {x, y};
  c.range_sigma = range_sigma;
  return c;
}

inline Cell cellAt(double x, double y, double resolution = 0.05) {
  return cellOf(Eigen::Vector2d(x, y) / resolution);
}

inline float valueAt(const OccupancyMap& map, double x, double y) {
  return map.logOdds(cellAt(x, y)).value_or(nan);
}

inline std::int8_t occupancyAt(const OccupancyMap& map, double x, double y) {
  const MapGeometry& g = map.geometry();
  const Cell cell = cellAt(x, y);
  return map.occupancy(static_cast<std::size_t>(cell.y - g.first.y) *
                           static_cast<std::size_t>(g.width) +
                       static_cast<std::size_t>(cell.x - g.first.x));
}

inline int knownCells(const OccupancyMap& map) {
  const MapGeometry& g = map.geometry();
  int known = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(g.width * g.height); ++i)
    known += map.probability(i) >= 0;
  return known;
}

/// No room around the robot but its own cell.
inline MapParameters withoutMargin() {
  MapParameters p;
  p.margin = 0.0;
  return p;
}

inline MapParameters withUpdate(MapUpdate update) {
  MapParameters p;
  p.update = update;
  return p;
}

/// A frame anywhere near the origin with bearings in all states and contacts on most of those that
/// are occupied.
inline Obstacles randomFrame(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  Obstacles frame =
      frameAt({3.0 * unit(random) - 2.0, 3.0 * unit(random) - 2.0, 6.3 * unit(random) - 3.1}, 0.07);
  for (int i = 0; i < 12; ++i) {
    const auto state = static_cast<BearingState>(random() % 4);
    const float angle = 0.5F - 0.09F * static_cast<float>(i), range = 0.3F + unit(random);
    frame.bearings.push_back(bearing(state, angle, range, 0.3F * unit(random)));
    if (state == BearingState::Occupied && random() % 4 != 0)
      frame.contacts.push_back(contactAt(0.07F + range * std::cos(angle), range * std::sin(angle),
                                         random() % 2 ? 0.2F * unit(random) : 0.0F));
  }
  return frame;
}

}  // namespace ipm_mapping::map_test
