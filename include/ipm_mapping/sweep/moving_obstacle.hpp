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
/// obstacle there. But it stands on floor that was seen free a moment ago. A beam is asked for the
/// first run of rows, from the near end on, with
///   sum over rows of w (min over references F - moving_cost) >= moving_score,
/// F up to 9 and not up to floor_cap, that is `moving_height` high. What begins there, well in
/// front of what the sweep has found if anything, has come if
/// - a reference, when it was the current frame, saw that place free: the change is in the current
///   frame, not in the reference, as where something has just left;
/// - in the same frame the place where it would have been if it went along with the robot was free
///   as well: highlights and mirror images of what is far away go along;
/// - beams beside have it too, `moving_width` together, twice that where the sweep has found
///   something behind. A few in between may lack it, since plain things look like floor in their
///   middle;
/// - the frame before had one no more than a step away.
/// What recedes uncovers its own foot and is not found. What stays is found by the sweep once the
/// references see it there.
class MovingObstacle {
 public:
  /// `max_range` in metres.
  void configure(const VerticalSweep& sweep, double max_range, const EvidenceParameters& evidence,
                 const SelectionParameters& selection, const MovingParameters& parameters);
  void reset();

  /// Fills choices of beams that have none, or one that is doubtful or clearly farther. Azimuths
  /// count from the camera's foot; `T_floor_foot` is its pose by the floor's own motion.
  void complete(const ComparedFrame& frame, const SE2& T_floor_foot, double stamp,
                std::vector<BeamChoice>& choices);
  /// A frame that may become a reference, and what it found.
  void remember(const SE2& T_floor_foot, const Obstacles& obstacles);

 private:
  void fillLeastCost(const ComparedFrame& frame, int beam, RowRange rows);
  [[nodiscard]] BeamChoice footOf(const ComparedFrame& frame, int beam);
  [[nodiscard]] bool isFoot(const BeamChoice& foot, int begin) const;
  [[nodiscard]] bool hasCome(const ComparedFrame& frame, const SE2& T_floor_foot,
                             const Eigen::Vector2d& p_foot) const;
  [[nodiscard]] bool inFrontOf(const BeamChoice& foot, const BeamChoice& choice) const;
  [[nodiscard]] Eigen::Vector2d footAt(int beam) const;
  void collectRun(int first);
  [[nodiscard]] double widthOfRun() const;
  [[nodiscard]] double widthAsked(const std::vector<BeamChoice>& choices) const;
  bool seenAgain(const SE2& T_floor_foot);
  void publishRun(std::vector<BeamChoice>& choices) const;

  MovingParameters parameters_;
  ScoreGrid grid_;
  std::uint16_t cost_ = 0;  // of a row that might as well be floor
  int least_rows_ = 0;
  std::vector<float> row_weight_;     // of every sweep row
  std::vector<std::uint16_t> least_;  // costs of the beam at hand
  std::vector<BeamChoice> come_;      // of every beam
  std::vector<int> run_;              // beams of the run at hand
  FloorHistory history_;
  std::vector<Eigen::Vector2d> feet_, feet_before_;  // on the floor: of this frame, the one before
  double feet_stamp_ = 0.0, longest_step_ = 0.0;
};

}  // namespace ipm_mapping::sweep
