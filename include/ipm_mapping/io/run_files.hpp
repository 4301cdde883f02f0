#pragma once

#include <fstream>
#include <string>

#include "ipm_mapping/obstacles.hpp"

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

}  // namespace ipm_mapping
