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
  /// One beam of the frame at hand.
  struct Column {
    const CurrentView& current;
    const SweepReference* references;
    int count;
    VerticalSweep& sweep;
    int beam;

    float score(int candidate, int slope, float least, std::int16_t& top) const {
      return sweep.leaningScore(references, count, beam, candidate, slope, least, top);
    }
  };
  struct Foot {
    int candidate = 0;
    int slope = 0;
    float score = 0.0F;
  };
  [[nodiscard]] Foot search(const Column& column, int centre, float most) const;
  void refineOne(const Column& column, SweepScores& scores, BeamChoice& choice);

  SelectionParameters parameters_;
  std::vector<float> score_;
  std::vector<std::int16_t> top_;
};

}  // namespace ipm_mapping::sweep
