#pragma once

#include <vector>

#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/foot_edge.hpp"
#include "ipm_mapping/sweep/sway.hpp"

namespace ipm_mapping::sweep {

/// What is lower than the camera shows its top as well as its face: a plank, a flat parcel, a
/// pallet's deck, a kerb. Their faces are a few rows, too little to be believed, but the top moves
/// like a raised floor. A candidate in view with a doubtful score, between `weak_share` of what is
/// published and `nearer_score`, gets the evidence of a level surface that begins where its face
/// ends,
///   S := max(S + max over t of S_top(t), clear),   top <= t <= top + top_reach,
/// clear = max(nearer_score, what is published),
/// where that surface is seen over `top_length`: what only looks upright (a joint that is not
/// aligned, a highlight) has none. It hides what scores more and stands behind it.
/// A pose that is stated too flat makes the floor itself look raised, by 2 tilt d at the distance
/// d: from where that is half of the lowest obstacle, nothing has a top. A face of a few rows is
/// hardly told from the rows of the top: such a candidate may lie on the top itself. Its surface is
/// followed towards the robot, and what it stands on is where that ends.
class LevelTop {
 public:
  void configure(const VerticalSweep& sweep, const SelectionParameters& parameters);

  /// Raises the scores of doubtful candidates, and of those around them, that have a top. `tilt`:
  /// what is known to be wrong with the pose in force.
  void add(const ComparedFrame& frame, const BearingSelection& selection, const Sway& tilt,
           SweepScores& scores);

 private:
  /// A level surface from sweep row `begin` upward.
  struct Top {
    int begin = 0;
    float score = 0.0F;
  };
  /// A doubtful candidate that has one.
  struct Slab {
    int candidate;
    float score;  ///< of its face
    Top top;
    int front;  ///< last row of the surface towards the robot
    float front_score;
  };
  void findSlabs(const ComparedFrame& frame, const BearingSelection& selection,
                 const SweepScores& scores, int beam, double farthest);
  [[nodiscard]] double farthest(double tilt) const;
  [[nodiscard]] Top topOf(const ComparedFrame& frame, int beam, int candidate, int top) const;
  static void raise(const Slab& slab, float clear, float* score, int candidates);
  static void moveToFront(const Slab& slab, int front, float clear, SweepScores& scores, int beam,
                          int candidates);

  SelectionParameters parameters_;
  int least_rows_ = 0;       // of a top
  int least_face_ = 0;       // rows: lower things are no obstacles
  int flat_face_ = 0;        // rows: higher ones stand where their face says
  std::vector<Slab> slabs_;  // of the beam at hand
};

}  // namespace ipm_mapping::sweep
