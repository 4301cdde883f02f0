#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/score_grid.hpp"

namespace ipm_mapping::sweep {

/// An obstacle is wider than a beam, or is still there in the next frame. A contact that no other
/// one stands beside, two beams to either side, is *doubtful* until `lone_frames` of the last
/// `lone_of` frames, its own included, had one there. Something that moves is seldom as narrow.
class LoneContact {
 public:
  void configure(const VerticalSweep& sweep, const SelectionParameters& parameters);
  void reset() { next_ = known_ = 0; }

  /// Marks the doubtful choices of a frame. `T_floor_foot`: pose of the camera's foot by the
  /// floor's own motion. What a robot sees that stands is not `new_evidence` for anything.
  void mark(const SE2& T_floor_foot, bool new_evidence, std::vector<BeamChoice>& choices);

 private:
  using Points = std::vector<Eigen::Vector2d>;

  [[nodiscard]] bool alone(const std::vector<BeamChoice>& choices, int beam) const;
  [[nodiscard]] bool saw(const Points& frame, const SE2& T_foot_floor, int beam,
                         const BeamChoice& choice) const;
  void remember(const SE2& T_floor_foot, const std::vector<BeamChoice>& choices);

  int lone_frames_ = 1;
  ScoreGrid grid_;
  std::vector<Points> frames_;  // ring: contacts on the floor
  std::size_t next_ = 0, known_ = 0;
};

}  // namespace ipm_mapping::sweep
