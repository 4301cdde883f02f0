#pragma once

#include <vector>

#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// Cones, heaps and cushions lean away from the camera: as vertical lines they are seen behind
/// their feet. In front of every contact, surfaces of a few slopes are tried too; one that explains
/// the column better by `lean_gain` takes its place, with the scores of the candidates around it.
class LeaningSurface {
 public:
  void configure(const SelectionParameters& parameters);

  /// Moves contacts to the feet of leaning surfaces; `scores` around them become theirs.
  void refine(const CurrentView& current, const SweepReference* references, int count,
              VerticalSweep& sweep, SweepScores& scores, std::vector<BeamChoice>& choices);

 private:
  void refineOne(const CurrentView& current, const SweepReference* references, int count,
                 VerticalSweep& sweep, SweepScores& scores, int beam, BeamChoice& choice);

  SelectionParameters parameters_;
  std::vector<float> score_, best_score_;
  std::vector<std::int16_t> top_, best_top_;
};

}  // namespace ipm_mapping::sweep
