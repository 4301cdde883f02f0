#include "ipm_mapping/sweep/foot_chain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ipm_mapping::sweep {
namespace {

constexpr int links = 2;          // beams back to the foot that a foot goes on from
constexpr double support = 0.6;   // camera heights above the foot
constexpr int least_members = 5;  // beams that speak together
constexpr float some_contrast = 1e-3F;

}  // namespace

void FootChain::configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                          const FootParameters& parameters) {
  parameters_ = parameters;
  plain_edge_.configure(sweep, free_floor, parameters);
  edge_.configure(sweep, free_floor, parameters);
  support_rows_ = static_cast<int>(std::lround(sweep.scoreGrid().rowsUp(support)));
  const auto beams = static_cast<std::size_t>(sweep.beams());
  feet_.resize(beams);
  found_.resize(beams);
  gain_.resize(support_rows_, sweep.beams());
  sum_.resize(static_cast<std::size_t>(support_rows_));
}

FootChain::Foot FootChain::footOf(const ComparedFrame& frame, int beam, const BeamChoice& choice) {
  Foot foot;
  if (choice.any()) {
    foot.candidate = choice.candidate;
    foot.contrast = FootEdge::contrastAt(frame, beam, choice);
    return foot;
  }
  const int edge = plain_edge_.nearest(frame.current, frame.references, frame.count, frame.sweep,
                                       beam, std::numeric_limits<double>::infinity());
  if (edge < 0) return foot;
  const int row = static_cast<int>(frame.sweep.sweepRow(edge));
  if (!edge_.floorInFront(frame, beam, row)) return foot;
  BeamChoice sharp;
  sharp.candidate = foot.candidate = FootEdge::sharpest(frame, beam, edge);
  foot.contrast = FootEdge::contrastAt(frame, beam, sharp);
  return foot;
}

/// A foot goes on from the one before it; one beam may lack a foot.
void FootChain::link() {
  const auto share = static_cast<float>(parameters_.foot_share);
  int chains = 0;
  for (std::size_t beam = 0; beam < feet_.size(); ++beam) {
    Foot& foot = feet_[beam];
    if (!foot.any() || std::abs(foot.contrast) < some_contrast) continue;
    foot.chain = chains++;
    for (std::size_t back = 1; back <= links && back <= beam; ++back) {
      const Foot& before = feet_[beam - back];
      if (before.chain < 0) continue;
      const float ratio = foot.contrast / before.contrast;
      const double step = static_cast<double>(std::abs(foot.candidate - before.candidate));
      if (step > parameters_.chain_step * static_cast<double>(back) || ratio < share ||
          ratio * share > 1.0F)
        continue;
      foot.chain = before.chain;
      break;
    }
  }
}

/// What the rows from the foot up to each row gain together, no beam more than its share.
void FootChain::fillGains(const ComparedFrame& frame, int beam) {
  const auto most = static_cast<float>(parameters_.chain_share);
  const auto candidate =
      static_cast<int>(std::lround(feet_[static_cast<std::size_t>(beam)].candidate));
  float* gain = gain_.row(beam);
  frame.sweep.aimBeam(frame.current, frame.references, frame.count, beam);
  frame.sweep.gains(frame.references, frame.count, beam, candidate, support_rows_, gain);
  float sum = 0.0F;
  std::fill_n(gain, PlainEdge::edge_rows, 0.0F);  // the edge itself blurs into the floor
  for (int o = 0; o < support_rows_; ++o) {
    sum += gain[o];
    gain[o] = std::min(sum, most);
  }
}

/// Nearest contact of a beam's chain to one side, within the gap, that is neither doubted nor a
/// guess; -1: none.
int FootChain::contactBeside(const std::vector<BeamChoice>& choices, int beam, int side) const {
  const int chain = feet_[static_cast<std::size_t>(beam)].chain;
  const int beams = static_cast<int>(feet_.size());
  for (int step = 1; step <= parameters_.chain_gap; ++step) {
    const int b = beam + side * step;
    if (b < 0 || b >= beams) return -1;
    const auto i = static_cast<std::size_t>(b);
    if (feet_[i].chain == chain && choices[i].any() && !choices[i].by_edge && !choices[i].doubtful)
      return b;
  }
  return -1;
}

BeamChoice FootChain::between(const ComparedFrame& frame, const std::vector<BeamChoice>& choices,
                              int beam) const {
  const int left = contactBeside(choices, beam, -1), right = contactBeside(choices, beam, 1);
  BeamChoice choice;
  if (left < 0 || right < 0 || right - left > parameters_.chain_gap) return choice;
  const BeamChoice& a = choices[static_cast<std::size_t>(left)];
  const BeamChoice& b = choices[static_cast<std::size_t>(right)];
  const auto rowsOf = [&](const BeamChoice& contact) {
    return static_cast<int>(frame.sweep.sweepRow(contact.candidate)) - contact.top;
  };
  choice.candidate = feet_[static_cast<std::size_t>(beam)].candidate;
  choice.score = static_cast<float>(parameters_.foot_score) * std::min(a.score, b.score);
  choice.top =
      static_cast<int>(frame.sweep.sweepRow(choice.candidate)) - std::min(rowsOf(a), rowsOf(b));
  choice.by_edge = true;
  return choice;
}

BeamChoice FootChain::together(const ComparedFrame& frame, int beam) {
  const Foot& foot = feet_[static_cast<std::size_t>(beam)];
  const int beams = static_cast<int>(feet_.size());
  std::fill(sum_.begin(), sum_.end(), 0.0F);
  int members = 0;
  for (int b = std::max(0, beam - parameters_.chain_beams);
       b <= std::min(beams - 1, beam + parameters_.chain_beams); ++b) {
    if (feet_[static_cast<std::size_t>(b)].chain != foot.chain) continue;
    const float* gain = gain_.row(b);
    for (std::size_t o = 0; o < sum_.size(); ++o) sum_[o] += gain[o];
    ++members;
  }
  BeamChoice choice;
  const auto best = std::max_element(sum_.begin(), sum_.end());
  if (members < least_members || best == sum_.end() ||
      static_cast<double>(*best) < parameters_.chain_score)
    return choice;
  choice.candidate = foot.candidate;
  choice.score = *best / static_cast<float>(members);
  choice.top = static_cast<int>(frame.sweep.sweepRow(choice.candidate)) -
               static_cast<int>(best - sum_.begin());
  choice.by_edge = true;
  return choice;
}

void FootChain::complete(const ComparedFrame& frame, std::vector<BeamChoice>& choices) {
  if (choices.size() != feet_.size()) return;
  if (parameters_.chain_gap == 0 && parameters_.chain_beams == 0) return;
  const int beams = static_cast<int>(feet_.size());
  for (int beam = 0; beam < beams; ++beam) {
    const auto i = static_cast<std::size_t>(beam);
    feet_[i] = footOf(frame, beam, choices[i]);
  }
  link();
  for (int beam = 0; parameters_.chain_beams > 0 && beam < beams; ++beam)
    if (feet_[static_cast<std::size_t>(beam)].chain >= 0) fillGains(frame, beam);
  for (int beam = 0; beam < beams; ++beam) {
    const auto i = static_cast<std::size_t>(beam);
    found_[i] = {};
    if (feet_[i].chain < 0 || choices[i].any()) continue;
    found_[i] = between(frame, choices, beam);
    if (!found_[i].any() && parameters_.chain_beams > 0) found_[i] = together(frame, beam);
  }
  for (std::size_t i = 0; i < choices.size(); ++i)
    if (found_[i].any()) choices[i] = found_[i];
}

}  // namespace ipm_mapping::sweep
