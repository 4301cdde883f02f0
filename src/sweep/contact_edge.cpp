#include "ipm_mapping/sweep/contact_edge.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {

float edgeContrast(const CurrentView& current, int first_line, int row) {
  std::int32_t sum = 0;
  for (int line = first_line; line < first_line + kernels::beam_lines; ++line) {
    const std::int16_t* grey = current.grey.row(line);
    sum += grey[row + 1] - grey[row - 1];
  }
  return static_cast<float>(sum) / (2.0F * kernels::beam_lines * kernels::grey_unit);
}

void ContactEdge::configure(const SelectionParameters& parameters) {
  parameters_ = parameters;
  merit_.resize(static_cast<std::size_t>(parameters.edge_farther + parameters.edge_nearer + 1));
}

void ContactEdge::refineOne(const CurrentView& current, const VerticalSweep& sweep,
                            const SweepScores& scores, int beam, BeamChoice& choice) {
  const int centre = static_cast<int>(std::lround(choice.candidate));
  const int first_row = static_cast<int>(sweep.sweepRow(0.0));
  const RowRange seen = sweep.rows(beam);
  const int from = std::max({0, centre - parameters_.edge_farther, seen.begin + 1 - first_row});
  const int to = std::min(
      {sweep.candidates() - 1, centre + parameters_.edge_nearer, seen.end - 2 - first_row});
  if (centre < from || centre > to) return;  // its foot is not in view
  const float* score = scores.score.row(beam);
  const auto gain = static_cast<float>(parameters_.edge_score);
  const auto half = static_cast<float>(parameters_.edge_contrast * parameters_.edge_contrast);
  for (int c = from; c <= to; ++c) {
    const float g = edgeContrast(current, sweep.firstLine(beam), first_row + c);
    merit_[static_cast<std::size_t>(c - from)] = score[c] + gain * g * g / (g * g + half);
  }
  const auto end = merit_.begin() + (to - from + 1);
  const auto best = std::max_element(merit_.begin(), end);
  const int moved_to = from + static_cast<int>(best - merit_.begin());
  choice.candidate = static_cast<float>(moved_to);
  if (score[moved_to] > 0.0F) choice.top = scores.top.at(moved_to, beam);
  if (best == merit_.begin() || best + 1 == end) return;
  choice.curvature = best[-1] - 2.0F * best[0] + best[1];
  if (choice.curvature < -1e-3F) choice.candidate += 0.5F * (best[-1] - best[1]) / choice.curvature;
}

void ContactEdge::refine(const CurrentView& current, const VerticalSweep& sweep,
                         const SweepScores& scores, std::vector<BeamChoice>& choices) {
  for (std::size_t beam = 0; beam < choices.size(); ++beam)
    if (choices[beam].any())
      refineOne(current, sweep, scores, static_cast<int>(beam), choices[beam]);
}

}  // namespace ipm_mapping::sweep
