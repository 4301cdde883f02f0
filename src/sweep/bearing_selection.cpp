#include "ipm_mapping/sweep/bearing_selection.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr int row_tolerance = 2;   // sweep rows by which supports may overlap and still be apart
constexpr int nearest_hops = 4;    // a nearer one may itself stand behind a nearer one
constexpr int straddle_reach = 2;  // beams on either side

}  // namespace

void BearingSelection::configure(const VerticalSweep& sweep, double height,
                                 const SelectionParameters& parameters) {
  parameters_ = parameters;
  beams_ = sweep.beams();
  candidates_ = sweep.candidates();
  first_row_ = static_cast<int>(sweep.sweepRow(0));
  distance_.clear();
  least_score_.clear();
  for (int c = 0; c < candidates_; ++c)
    distance_.push_back(static_cast<float>(sweep.distance(c) / height));
  for (int c = 0; c < candidates_; ++c)
    least_score_.push_back(static_cast<float>(
        std::max(parameters.publish_score, parameters.publish_slope * sweep.r(c))));
  prepared_.resize(candidates_, beams_);
  came_from_.resize(candidates_ + 1, beams_);
  const auto n = static_cast<std::size_t>(candidates_);
  cost_.resize(n);
  reached_.resize(n);
  from_.resize(n);
  path_.resize(static_cast<std::size_t>(beams_));
}

/// The best candidate, then the nearest clear one in front of it.
int BearingSelection::strongestVisible(const float* score, const std::int16_t* top) const {
  int best = static_cast<int>(std::max_element(score, score + candidates_) - score);
  if (!(score[best] > static_cast<float>(parameters_.nearer_score))) return -1;
  for (int hop = 0; hop < nearest_hops; ++hop) {
    const int contact_row = first_row_ + best;
    int nearer = -1;
    auto most = static_cast<float>(parameters_.nearer_score);
    for (int c = best + 1; c < candidates_; ++c) {
      if (top[c] < contact_row || !(score[c] > most)) continue;
      most = score[c];
      nearer = c;
    }
    if (nearer < 0) break;
    best = nearer;
  }
  return best;
}

void BearingSelection::prepare(const SweepScores& scores, int beam) {
  const float* score = scores.score.row(beam);
  float* out = prepared_.row(beam);
  std::copy(score, score + candidates_, out);
  const int visible = strongestVisible(score, scores.top.row(beam));
  if (visible < 0) return;
  const int hidden = scores.top.at(visible, beam) + row_tolerance - first_row_;
  for (int c = 0; c < std::min(hidden + 1, visible); ++c) out[c] = 0.0F;
  const float most = *std::max_element(out, out + candidates_);
  const auto cap = static_cast<float>(parameters_.score_cap);
  if (most <= cap) return;
  for (int c = 0; c < candidates_; ++c) out[c] *= cap / most;
}

/// Costs of reaching every state of a beam from the beam to its left.
void BearingSelection::advance(int beam) {
  const auto step = static_cast<float>(parameters_.step_cost);
  const auto jump = static_cast<float>(parameters_.jump_cost);
  const auto appear = static_cast<float>(parameters_.nothing_cost);
  const auto none = static_cast<std::int16_t>(candidates_);
  const auto cheapest = std::min_element(cost_.begin(), cost_.end());
  const float least = *cheapest;
  const auto least_at = static_cast<std::int16_t>(cheapest - cost_.begin());
  for (std::size_t c = 0; c < cost_.size(); ++c) {
    reached_[c] = cost_[c];
    from_[c] = static_cast<std::int16_t>(c);
  }
  for (std::size_t c = 1; c < cost_.size(); ++c)
    if (reached_[c - 1] + step < reached_[c])
      reached_[c] = reached_[c - 1] + step, from_[c] = from_[c - 1];
  for (std::size_t c = cost_.size() - 1; c-- > 0;)
    if (reached_[c + 1] + step < reached_[c])
      reached_[c] = reached_[c + 1] + step, from_[c] = from_[c + 1];
  for (std::size_t c = 0; c < cost_.size(); ++c) {
    if (least + jump < reached_[c]) reached_[c] = least + jump, from_[c] = least_at;
    if (nothing_ + appear < reached_[c]) reached_[c] = nothing_ + appear, from_[c] = none;
  }
  std::int16_t* link = came_from_.row(beam);
  std::copy(from_.begin(), from_.end(), link);
  link[candidates_] = none;
  if (least + appear < nothing_) nothing_ = least + appear, link[candidates_] = least_at;
}

void BearingSelection::forward() {
  for (int beam = 0; beam < beams_; ++beam) {
    if (beam == 0) {
      nothing_ = 0.0F;
      std::fill(reached_.begin(), reached_.end(), static_cast<float>(parameters_.nothing_cost));
    } else {
      advance(beam);
    }
    const float* score = prepared_.row(beam);
    for (std::size_t c = 0; c < cost_.size(); ++c)
      cost_[c] = reached_[c] + static_cast<float>(parameters_.presence_cost) - score[c];
  }
}

/// State of every beam on the cheapest path; candidates_ is 'nothing'.
void BearingSelection::backward(std::vector<int>& path) const {
  const auto cheapest = std::min_element(cost_.begin(), cost_.end());
  int state = candidates_;
  if (*cheapest + static_cast<float>(parameters_.nothing_cost) < nothing_)
    state = static_cast<int>(cheapest - cost_.begin());
  for (int beam = beams_ - 1; beam >= 0; --beam) {
    path[static_cast<std::size_t>(beam)] = state;
    if (beam > 0) state = came_from_.at(state, beam);
  }
}

BeamChoice BearingSelection::ownMaximum(const SweepScores& scores, int beam, int near) const {
  const float* s = scores.score.row(beam);
  const int from = std::max(0, near - parameters_.refine_steps);
  const int to = std::min(candidates_ - 1, near + parameters_.refine_steps);
  const int best = static_cast<int>(std::max_element(s + from, s + to + 1) - s);
  BeamChoice choice;
  choice.score = s[best];
  if (!(choice.score >= least_score_[static_cast<std::size_t>(best)])) return choice;
  choice.candidate = static_cast<float>(best);
  choice.top = scores.top.at(best, beam);
  if (best == 0 || best == candidates_ - 1) return choice;
  choice.curvature = s[best - 1] - 2.0F * s[best] + s[best + 1];
  if (choice.curvature < -1e-3F && s[best] >= s[best - 1] && s[best] >= s[best + 1])
    choice.candidate += 0.5F * (s[best - 1] - s[best + 1]) / choice.curvature;
  return choice;
}

float BearingSelection::distanceOf(const BeamChoice& choice) const {
  const int c = static_cast<int>(std::lround(choice.candidate));
  return distance_[static_cast<std::size_t>(std::clamp(c, 0, candidates_ - 1))];
}

/// A beam beside a nearer, stronger contact sees both the obstacle's side and what is behind it:
/// its contact is dropped, unless the beams on the other side see the same thing (a wall that
/// recedes, or the background itself). Between nearer contacts on both sides it is dropped however
/// strong it is: a silhouette scores high, and nothing passes through a gap of a beam or two.
bool BearingSelection::straddles(const std::vector<BeamChoice>& choices, int beam) const {
  const auto gap = static_cast<float>(parameters_.straddle_gap);
  const auto ratio = static_cast<float>(parameters_.straddle_ratio);
  const BeamChoice& here = choices[static_cast<std::size_t>(beam)];
  if (!here.any()) return false;
  int sides_nearer = 0;
  for (const int side : {-1, 1}) {
    bool any_nearer = false, hidden = false, confirmed = false;
    for (int step = 1; step <= straddle_reach; ++step) {
      const int nearer = beam + side * step, other = beam - side * step;
      if (nearer >= 0 && nearer < beams_) {
        const BeamChoice& there = choices[static_cast<std::size_t>(nearer)];
        const bool is_nearer = there.any() && distanceOf(here) - distanceOf(there) > gap;
        any_nearer |= is_nearer;
        hidden |= is_nearer && there.score > ratio * here.score;
      }
      if (other >= 0 && other < beams_) {
        const BeamChoice& there = choices[static_cast<std::size_t>(other)];
        confirmed |= there.any() && std::abs(distanceOf(here) - distanceOf(there)) <
                                        gap * static_cast<float>(step);
      }
    }
    if (hidden && !confirmed) return true;
    sides_nearer += any_nearer ? 1 : 0;
  }
  return sides_nearer == 2;
}

void BearingSelection::select(const SweepScores& scores, std::vector<BeamChoice>& choices) {
  choices.assign(static_cast<std::size_t>(beams_), BeamChoice{});
  if (beams_ == 0 || candidates_ == 0) return;
  for (int beam = 0; beam < beams_; ++beam) prepare(scores, beam);
  forward();
  backward(path_);
  for (int beam = 0; beam < beams_; ++beam) {
    const int state = path_[static_cast<std::size_t>(beam)];
    if (state < candidates_)
      choices[static_cast<std::size_t>(beam)] = ownMaximum(scores, beam, state);
  }
  if (!parameters_.straddle) return;
  for (int beam = 0; beam < beams_; ++beam)
    path_[static_cast<std::size_t>(beam)] = straddles(choices, beam) ? 1 : 0;
  for (int beam = 0; beam < beams_; ++beam)
    if (path_[static_cast<std::size_t>(beam)] != 0)
      choices[static_cast<std::size_t>(beam)].candidate = -1.0F;
}

}  // namespace ipm_mapping::sweep
