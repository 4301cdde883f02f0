#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/memory_parameters.hpp"

namespace ipm_mapping {

/// Filter over time: a contact counts when contacts lay within `confirm_radius` of it, on the floor
/// of the odometry frame, in `confirm_frames` of the last `confirm_of` used frames, its own
/// included. Does nothing unless `filter` is on. An answer of age above 0 is no new evidence: its
/// contacts have to have been confirmed before. A contact of age above 0, which its detector
/// holds, confirms nothing either.
class ContactConfirmation {
 public:
  explicit ContactConfirmation(const MemoryParameters& parameters = {});

  void clear() { known_ = 0; }
  /// Takes an answer and leaves its confirmed contacts; bearings that lose their
  /// contact say nothing any more. Allocates only while the number of bearings grows.
  void apply(Obstacles& obstacles);

 private:
  using Points = std::vector<Eigen::Vector2d>;

  void remember();
  [[nodiscard]] bool confirmed(const Eigen::Vector2d& p_odom) const;

  MemoryParameters parameters_;
  Points seen_;                 // contacts of this frame, in odom
  std::vector<Points> frames_;  // ring of those of used frames
  std::size_t next_ = 0, known_ = 0;
};

}  // namespace ipm_mapping
