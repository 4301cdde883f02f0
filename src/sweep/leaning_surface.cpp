#include "ipm_mapping/sweep/leaning_surface.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr int raster = 3;             // candidates
constexpr float coarse_share = 0.9F;  // of the upright score: what the raster may miss of a peak

}  // namespace

void LeaningSurface::configure(const SelectionParameters& parameters) {
  parameters_ = parameters;
  const auto n = static_cast<std::size_t>(parameters.edge_farther + parameters.edge_nearer + 1);
  score_.resize(n);
  top_.resize(n);
}

/// The best slope and foot on a coarse raster.
LeaningSurface::Foot LeaningSurface::search(const Column& column, int centre, float most) const {
  Foot best;
  std::int16_t top = 0;
  const int last = std::min(column.sweep.candidates() - 1, centre + parameters_.lean_reach);
  for (int slope = 0; slope < static_cast<int>(VerticalSweep::lean_slopes.size()); ++slope) {
    for (int c = std::max(0, centre - raster); c <= last; c += raster) {
      const float score = column.score(c, slope, std::max(coarse_share * most, best.score), top);
      if (score > best.score) best = {c, slope, score};
    }
  }
  return best;
}

void LeaningSurface::refineOne(const Column& column, SweepScores& scores, BeamChoice& choice) {
  const int centre = static_cast<int>(std::lround(choice.candidate));
  const float upright = scores.score.at(centre, column.beam);
  const float most = upright * static_cast<float>(parameters_.lean_gain);
  if (upright > static_cast<float>(parameters_.lean_doubt) *
                    column.sweep.offered(column.references, column.count, column.beam, centre))
    return;
  column.sweep.aimBeam(column.current, column.references, column.count, column.beam);
  const Foot foot = search(column, centre, most);
  if (foot.score <= 0.0F) return;
  const int from = std::max(0, foot.candidate - parameters_.edge_farther);
  const int to = std::min(column.sweep.candidates() - 1, foot.candidate + parameters_.edge_nearer);
  const auto n = static_cast<std::ptrdiff_t>(to - from + 1);
  for (int c = from; c <= to; ++c)
    score_[static_cast<std::size_t>(c - from)] =
        column.score(c, foot.slope, 0.0F, top_[static_cast<std::size_t>(c - from)]);
  const auto best = std::max_element(score_.begin(), score_.begin() + n);
  if (!(*best > most)) return;
  std::copy_n(score_.begin(), n, scores.score.row(column.beam) + from);
  std::copy_n(top_.begin(), n, scores.top.row(column.beam) + from);
  choice.candidate = static_cast<float>(from + (best - score_.begin()));
  choice.score = *best;
  choice.top = top_[static_cast<std::size_t>(best - score_.begin())];
}

void LeaningSurface::refine(const CurrentView& current, const SweepReference* references, int count,
                            VerticalSweep& sweep, SweepScores& scores,
                            std::vector<BeamChoice>& choices) {
  if (parameters_.lean_reach == 0) return;
  for (std::size_t beam = 0; beam < choices.size(); ++beam)
    if (choices[beam].any())
      refineOne({current, references, count, sweep, static_cast<int>(beam)}, scores, choices[beam]);
}

}  // namespace ipm_mapping::sweep
