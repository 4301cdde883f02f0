#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/memory_parameters.hpp"

namespace ipm_mapping {

/// Filter over time: a contact counts when contacts lay within `confirm_radius` of it, on the floor
/// of the odometry frame, in `confirm_frames` of the last `confirm_of` used frames, its own
/// included. Does nothing unless `filter` is on.
class ContactConfirmation {
 public:
  explicit ContactConfirmation(const MemoryParameters& parameters = {});

  void clear() { known_ = 0; }
  /// Takes a used frame's answer and leaves its confirmed contacts; bearings that lose their
  /// contact say nothing any more. Allocates only while the number of bearings grows.
  void apply(Obstacles& obstacles);

 private:
  using Points = std::vector<Eigen::Vector2d>;

  [[nodiscard]] bool confirmed(const Eigen::Vector2d& p_odom) const;

  MemoryParameters parameters_;
  std::vector<Points> frames_;  // ring: contacts in odom, as they were seen
  std::size_t next_ = 0, known_ = 0;
};

}  // namespace ipm_mapping
