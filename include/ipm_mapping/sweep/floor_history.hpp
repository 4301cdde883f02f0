#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"

namespace ipm_mapping::sweep {

/// In which of the last frames each place of the floor around the robot was seen free, and where
/// the camera's foot was then.
class FloorHistory {
 public:
  static constexpr int most_frames = 128;

  /// `cell` metres a side; places that lie `reach` metres apart are not taken for one another.
  void configure(double cell, double reach);
  void clear();

  /// What is set free from now on is so in this frame.
  void beginFrame(double stamp, const Eigen::Vector2d& p_floor_foot);
  void setFree(const Eigen::Vector2d& p_floor);

  /// How many frames ago the one with this stamp was; negative where it is not known.
  [[nodiscard]] int framesAgo(double stamp) const;
  /// `frames_ago` as framesAgo() gives it, not negative.
  [[nodiscard]] bool wasFree(const Eigen::Vector2d& p_floor, int frames_ago) const;
  [[nodiscard]] const Eigen::Vector2d& foot(int frames_ago) const;
  [[nodiscard]] double cell() const { return cell_; }

 private:
  struct Cell {
    std::int64_t newest = 0;        ///< frame in which it was free
    std::bitset<most_frames> free;  ///< the first bit for that frame, the next for the one before
  };
  struct Seen {
    double stamp = 0.0;
    Eigen::Vector2d p_floor_foot = Eigen::Vector2d::Zero();
  };
  [[nodiscard]] std::size_t indexOf(const Eigen::Vector2d& p_floor) const;
  [[nodiscard]] static std::size_t slot(std::int64_t frame) {
    return static_cast<std::size_t>(frame % most_frames);
  }

  double cell_ = 1.0;
  int side_ = 1;
  std::vector<Cell> cells_;  // the floor, wrapped around on both axes
  std::int64_t frame_ = 0;   // the newest; the first is 1
  std::array<Seen, most_frames> frames_;
};

}  // namespace ipm_mapping::sweep
