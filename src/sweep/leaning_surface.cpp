#include "ipm_mapping/sweep/leaning_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr std::array<double, 3> slopes{0.2, 0.35, 0.6};  // metres away per metre of height

}  // namespace

void LeaningSurface::configure(const SelectionParameters& parameters) {
  parameters_ = parameters;
  const auto n = static_cast<std::size_t>(parameters.lean_reach + parameters.edge_farther + 1);
  score_.resize(n);
  best_score_.resize(n);
  top_.resize(n);
  best_top_.resize(n);
}

void LeaningSurface::refineOne(const CurrentView& current, const SweepReference* references,
                               int count, VerticalSweep& sweep, SweepScores& scores, int beam,
                               BeamChoice& choice) {
  const int centre = static_cast<int>(std::lround(choice.candidate));
  const int from = std::max(0, centre - parameters_.edge_farther);
  const int to = std::min(sweep.candidates() - 1, centre + parameters_.lean_reach);
  const auto n = static_cast<std::size_t>(to - from + 1);
  float most = scores.score.at(centre, beam) * static_cast<float>(parameters_.lean_gain);
  std::size_t best = n;
  sweep.aimBeam(references, count, beam);
  for (const double slope : slopes) {
    for (std::size_t k = 0; k < n; ++k)
      score_[k] = sweep.leaningScore(current, references, count, beam, from + static_cast<int>(k),
                                     slope, top_[k]);
    const auto at = std::max_element(score_.begin(), score_.begin() + static_cast<long>(n));
    if (!(*at > most)) continue;
    most = *at;
    best = static_cast<std::size_t>(at - score_.begin());
    std::swap(score_, best_score_);
    std::swap(top_, best_top_);
  }
  if (best == n) return;
  for (std::size_t k = 0; k < n; ++k) {
    scores.score.at(from + static_cast<int>(k), beam) = best_score_[k];
    scores.top.at(from + static_cast<int>(k), beam) = best_top_[k];
  }
  choice.candidate = static_cast<float>(from + static_cast<int>(best));
  choice.score = most;
  choice.top = best_top_[best];
}

void LeaningSurface::refine(const CurrentView& current, const SweepReference* references, int count,
                            VerticalSweep& sweep, SweepScores& scores,
                            std::vector<BeamChoice>& choices) {
  if (parameters_.lean_reach == 0) return;
  for (std::size_t beam = 0; beam < choices.size(); ++beam)
    if (choices[beam].any())
      refineOne(current, references, count, sweep, scores, static_cast<int>(beam), choices[beam]);
}

}  // namespace ipm_mapping::sweep
