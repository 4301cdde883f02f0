#pragma once

#include <Eigen/Core>
#include <cmath>

#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping::sweep {

/// Places in the table of scores, beams x candidates, fractions allowed, and what they are on the
/// floor around the camera's foot.
struct ScoreGrid {
  double first_azimuth = 0.0, azimuth_step = 1.0;      ///< radians
  double first_slope = 1.0, candidates_per_log = 1.0;  ///< slope r = height / distance
  double height = 1.0;                                 ///< of the camera, metres

  [[nodiscard]] double azimuth(double beam) const { return first_azimuth + beam * azimuth_step; }
  [[nodiscard]] double slope(double candidate) const {
    return first_slope * std::exp(candidate / candidates_per_log);
  }
  [[nodiscard]] double candidateOfSlope(double r) const {
    return candidates_per_log * std::log(r / first_slope);
  }
  /// Rows from the foot of an upright line to a point of it, `share` of the camera's height up.
  [[nodiscard]] double rowsUp(double share) const {
    return -std::log1p(-share) * candidates_per_log;
  }
  [[nodiscard]] double candidate(double distance) const {
    return candidateOfSlope(height / distance);
  }
  [[nodiscard]] double beam(const Eigen::Vector2d& p_foot) const {
    return wrapAngle(std::atan2(p_foot.y(), p_foot.x()) - first_azimuth) / azimuth_step;
  }
  [[nodiscard]] Eigen::Vector2d point(double beam, double candidate) const {
    const double distance = height / slope(candidate);
    return distance * Eigen::Vector2d(std::cos(azimuth(beam)), std::sin(azimuth(beam)));
  }
};

}  // namespace ipm_mapping::sweep
