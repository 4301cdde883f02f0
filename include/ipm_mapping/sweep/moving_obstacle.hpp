#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/floor_history.hpp"
#include "ipm_mapping/sweep/foot_edge.hpp"
#include "ipm_mapping/sweep/score_grid.hpp"

namespace ipm_mapping::sweep {

/// What moves has no parallax that fits any place on the floor: the sweep sees neither floor nor
/// obstacle there. But it stands on floor that was seen free a moment ago. A beam without a contact
/// is asked for the first run of rows, from the near end on, with
///   sum over rows of w (min over references F - moving_cost) >= moving_score,
/// F up to 9 and not up to floor_cap, that is `moving_height` high. What begins there has come if
/// - a reference, when it was the current frame, saw that place free: the change is in the current
///   frame, not in the reference, as where something has just left;
/// - in the same frame the place where it would have been if it went along with the robot was free
///   as well: highlights and mirror images of what is far away go along;
/// - beams beside have it too, `moving_width` together, a few that lack it in between: what is
/// plain
///   looks like floor there;
/// - the frame before had one no more than a step away.
/// What recedes uncovers its own foot and is not found. What stays is found by the sweep once the
/// references see it there.
class MovingObstacle {
 public:
  /// `max_range` in metres.
  void configure(const VerticalSweep& sweep, double max_range, const EvidenceParameters& evidence,
                 const MovingParameters& parameters);
  void reset();

  /// Fills choices of beams that have none. Azimuths count from the camera's foot; `T_floor_foot`
  /// is its pose by the floor's own motion.
  void complete(const ComparedFrame& frame, const SE2& T_floor_foot,
                std::vector<BeamChoice>& choices);
  /// A frame that may become a reference, and what it found.
  void remember(const SE2& T_floor_foot, const Obstacles& obstacles);

 private:
  [[nodiscard]] BeamChoice footOf(const ComparedFrame& frame, int beam) const;
  [[nodiscard]] bool isFoot(const BeamChoice& foot, int begin) const;
  [[nodiscard]] bool hasCome(const ComparedFrame& frame, const SE2& T_floor_foot,
                             const Eigen::Vector2d& p_foot) const;
  [[nodiscard]] int endOfRun(int first) const;
  bool seenAgain(const SE2& T_floor_foot, int first, int end);
  [[nodiscard]] double widthOf(int first, int end) const;
  void publish(int first, int end, std::vector<BeamChoice>& choices) const;

  MovingParameters parameters_;
  ScoreGrid grid_;
  std::int32_t cost_ = 0;  // of a row that might as well be floor
  int least_rows_ = 0;
  std::vector<float> row_weight_;  // of every sweep row
  std::vector<BeamChoice> come_;   // of every beam
  FloorHistory history_;
  std::vector<Eigen::Vector2d> feet_, feet_before_;  // on the floor: of this frame, the one before
};

}  // namespace ipm_mapping::sweep
