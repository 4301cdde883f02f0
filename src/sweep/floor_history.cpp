#include "ipm_mapping/sweep/floor_history.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {

void FloorHistory::configure(double cell, double reach) {
  cell_ = cell;
  side_ = std::max(1, static_cast<int>(std::ceil(reach / cell)));
  cells_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
  clear();
}

void FloorHistory::clear() {
  std::fill(cells_.begin(), cells_.end(), Cell{});
  frame_ = 0;
}

std::size_t FloorHistory::indexOf(const Eigen::Vector2d& p_floor) const {
  const auto wrapped = [&](double metres) {
    const auto turns = std::fmod(std::floor(metres / cell_), side_);
    return static_cast<std::size_t>(turns < 0.0 ? turns + side_ : turns);
  };
  return wrapped(p_floor.y()) * static_cast<std::size_t>(side_) + wrapped(p_floor.x());
}

void FloorHistory::beginFrame(double stamp, const Eigen::Vector2d& p_floor_foot) {
  frames_[slot(++frame_)] = {stamp, p_floor_foot};
}

void FloorHistory::setFree(const Eigen::Vector2d& p_floor) {
  Cell& cell = cells_[indexOf(p_floor)];
  const std::int64_t passed = frame_ - cell.newest;
  cell.free <<= static_cast<std::size_t>(passed);
  cell.free.set(0);
  cell.newest = frame_;
}

int FloorHistory::framesAgo(double stamp) const {
  const auto known = static_cast<int>(std::min<std::int64_t>(frame_, most_frames));
  for (int ago = 0; ago < known; ++ago)
    if (frames_[slot(frame_ - ago)].stamp == stamp) return ago;
  return -1;
}

bool FloorHistory::wasFree(const Eigen::Vector2d& p_floor, int frames_ago) const {
  const Cell& cell = cells_[indexOf(p_floor)];
  const std::int64_t bit = frames_ago - (frame_ - cell.newest);
  return bit >= 0 && bit < most_frames && cell.free[static_cast<std::size_t>(bit)];
}

const Eigen::Vector2d& FloorHistory::foot(int frames_ago) const {
  return frames_[slot(frame_ - frames_ago)].p_floor_foot;
}

}  // namespace ipm_mapping::sweep
