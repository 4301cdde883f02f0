#pragma once

#include <cmath>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"

namespace ipm_mapping::sweep {

/// The grid of the cylindrical rectification. A *line* holds what is seen at one azimuth around the
/// camera; its *rows* run from far to near in equal steps of ln r, r = tan(depression below the
/// horizon) = height / floor distance.
///
/// Two facts make the sweep fast: a vertical edge lies on one line whatever the camera's pose, and
/// between two places from which the edge is seen at distances d and d', it moves by the same
/// number of rows, rows_per_log * ln(d / d'), at every height.
///
/// Costs are evaluated on every second row, the *sweep rows*: sweep row j is row 2j.
struct PolarGrid {
  static constexpr int rows_per_sweep_row = 2;

  int lines = 0;
  int rows = 0;  ///< even
  double left_azimuth = 0.0;
  double lines_per_radian = 1.0;
  double rows_per_log = 1.0;
  double log_r_far = 0.0;  ///< ln r of row 0
  double height = 1.0;     ///< of the camera over the floor, metres

  [[nodiscard]] int sweepRows() const { return rows / rows_per_sweep_row; }
  [[nodiscard]] double azimuth(double line) const { return left_azimuth - line / lines_per_radian; }
  [[nodiscard]] double line(double azimuth) const {
    return (left_azimuth - azimuth) * lines_per_radian;
  }
  [[nodiscard]] double r(double row) const { return std::exp(log_r_far + row / rows_per_log); }
  [[nodiscard]] double distance(double row) const { return height / r(row); }
  [[nodiscard]] double row(double distance) const {
    return (std::log(height / distance) - log_r_far) * rows_per_log;
  }
};

/// Grid that covers what the camera sees of the floor, from `max_range * beyond` (seen over the
/// highest support) to the foot of the image. `lines` = 0 where the camera sees no floor.
[[nodiscard]] PolarGrid makePolarGrid(const CameraModel& camera, const CameraPose& T_base_camera,
                                      const GridParameters& parameters, double max_range);

/// max_range, or the automatic one where it is 0: max(2 m, 3 x nearestVisibleFloor()).
[[nodiscard]] double effectiveMaxRange(const CameraModel& camera, const CameraPose& T_base_camera,
                                       double max_range);

/// Raw pixel that sees azimuth and r; false behind the camera or beyond the lens' turning radius.
[[nodiscard]] bool rawPixel(const CameraModel& camera, const CameraPose& T_base_camera,
                            double azimuth, double r, double& u, double& v);
/// The same before distortion.
[[nodiscard]] bool undistortedPixel(const CameraModel& camera, const CameraPose& T_base_camera,
                                    double azimuth, double r, double& u, double& v);

}  // namespace ipm_mapping::sweep
