#pragma once
// The synthetic robot's box as a map shows it.

#include <nav_msgs/OccupancyGrid.h>

#include <algorithm>
#include <cmath>

namespace ipm_mapping {

/// Distance from the outline of the synthetic robot's box.
inline double fromBox(double x, double y) {
  const double dx = std::max({1.5 - x, x - 1.8, 0.0}), dy = std::max({-0.25 - y, y - 0.15, 0.0});
  const double inside = std::min({x - 1.5, 1.8 - x, y + 0.25, 0.15 - y});
  return inside > 0.0 ? inside : std::hypot(dx, dy);
}

/// What a map shows of it.
struct Occupied {
  int cells = 0, on_the_front = 0;
  double farthest = 0.0;

  explicit Occupied(const nav_msgs::OccupancyGrid& map) {
    for (std::uint32_t i = 0; i < map.data.size(); ++i) {
      if (map.data[i] != 100) continue;
      const double x = map.info.origin.position.x + (i % map.info.width + 0.5) * resolution;
      const double y = map.info.origin.position.y + (i / map.info.width + 0.5) * resolution;
      ++cells;
      on_the_front += std::abs(x - 1.5) < 0.06 && y > -0.25 && y < 0.15;
      farthest = std::max(farthest, fromBox(x, y));
    }
  }
  static constexpr double resolution = 0.05;
};

}  // namespace ipm_mapping
