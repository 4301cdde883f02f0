#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// What one beam settles for.
struct BeamChoice {
  float candidate = -1.0F;  ///< fraction by a parabola; negative: nothing
  float score = 0.0F;       ///< the beam's own
  float curvature = 0.0F;   ///< of the score at its maximum, per candidate^2, <= 0
  int top = 0;              ///< sweep row where the support ends
  bool by_edge =
      false;  ///< a known foot, found again by its edge (FootEdge): no parallax of its own
  bool doubtful = false;  ///< alone or low: neither contact nor free floor
  bool moving = false;    ///< has come onto free floor
  [[nodiscard]] bool any() const { return candidate >= 0.0F; }
};

/// One contact a beam, smooth over bearings. Per beam the best candidate, or a nearer one with a
/// clear score of its own that ends at or below it (it hides what is behind); what is behind the
/// choice is erased. Then Viterbi over the beams with a state for 'nothing':
///   cost = sum presence - S + min(step |b - b'|, jump), nothing to go to and from 'nothing';
/// scores are scaled per beam, not clipped, to `score_cap`: a clipped score has no maximum. At last
/// the beam's own maximum near the path.
class BearingSelection {
 public:
  void configure(const VerticalSweep& sweep, double height, const SelectionParameters& parameters);

  /// Fills one choice a beam.
  void select(const SweepScores& scores, std::vector<BeamChoice>& choices);

  /// Score that a contact at a candidate needs to be published.
  [[nodiscard]] float leastScore(int candidate) const {
    return least_score_[static_cast<std::size_t>(candidate)];
  }

 private:
  int strongestVisible(const float* score, const std::int16_t* top) const;
  void prepare(const SweepScores& scores, int beam);
  void forward();
  void advance(int beam);
  void backward(std::vector<int>& path) const;
  BeamChoice ownMaximum(const SweepScores& scores, int beam, int near) const;
  float distanceOf(const BeamChoice& choice) const;
  bool straddles(const std::vector<BeamChoice>& choices, int beam) const;

  SelectionParameters parameters_;
  int beams_ = 0, candidates_ = 0, first_row_ = 0;
  std::vector<float> distance_;     // of every candidate, in camera heights
  std::vector<float> least_score_;  // to be published
  Image<float> prepared_;           // candidates x beams
  Image<std::int16_t> came_from_;   // candidates + 1 x beams; the last state is 'nothing'
  std::vector<float> cost_, reached_;
  std::vector<std::int16_t> from_;
  float nothing_ = 0.0F;
  std::vector<int> path_;
};

}  // namespace ipm_mapping::sweep
