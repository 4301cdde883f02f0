#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/mapping/occupancy_map.hpp"

namespace ipm_mapping {

/// An outline on the floor, metres in the map's frame.
struct Outline {
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
};

/// What is drawn beside the cells.
struct MapAnnotations {
  std::string title;
  std::vector<SE2> trajectory;  ///< robot poses in the map's frame, in order of time
  std::vector<Outline> truth;   ///< true outlines where they are known
};

/// The map for people: cropped to what is known, with a metric grid, trajectory, scale bar, legend
/// and, where known, the truth. x points right, y up. BGR.
[[nodiscard]] cv::Mat drawMap(const TrinaryMap& map, const MapAnnotations& annotations);

}  // namespace ipm_mapping
