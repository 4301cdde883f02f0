#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/sweep/floor_odometry.hpp"

namespace ipm_mapping {

/// The two tables of a run: `points.csv`, one selected contact a row, and `obstacles.csv`, every
/// bearing of every used frame. Columns are a contract with scripts that read them.
class RunFiles {
 public:
  /// Creates both files in an existing folder; throws std::runtime_error naming the file.
  explicit RunFiles(const std::string& directory);

  void add(const Obstacles& obstacles);
  /// Closes both files; throws std::runtime_error when something was not written.
  void finish();
  [[nodiscard]] std::size_t points() const { return points_; }

 private:
  std::string directory_;
  std::ofstream points_csv_, obstacles_csv_;
  std::size_t points_ = 0;
};

/// Where the robot was at one frame.
struct TrackedFrame {
  std::uint64_t frame = 0;
  double stamp = 0.0;        ///< seconds
  SE2 T_odom_base;           ///< wheel odometry
  sweep::FloorPose refined;  ///< wheels and floor
};

/// Writes `trajectory.csv` into an existing folder: every frame's pose by wheel odometry, by wheels
/// and floor, and the covariance of the latter. Throws std::runtime_error naming the file.
void writeTrajectory(const std::string& directory, const std::vector<TrackedFrame>& frames);

}  // namespace ipm_mapping
