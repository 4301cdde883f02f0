#include "ipm_mapping/sweep/remembered_foot.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr double most_frames = 100.0;  // within foot_memory: faster cameras see the same again
constexpr double same_place = 5.0;     // candidates

}  // namespace

void RememberedFoot::configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                               const FootParameters& parameters) {
  parameters_ = parameters;
  edge_.configure(sweep, free_floor, parameters);
  grid_ = sweep.scoreGrid();
  known_.clear();
  known_.reserve(static_cast<std::size_t>(most_frames) * static_cast<std::size_t>(sweep.beams()));
  newest_.resize(static_cast<std::size_t>(sweep.beams()));
}

void RememberedFoot::forget(double seconds) {
  const auto old = [&](const Known& k) { return seconds - k.seconds > parameters_.foot_memory; };
  known_.erase(std::remove_if(known_.begin(), known_.end(), old), known_.end());
}

/// The newest of what is known in the direction of every beam.
void RememberedFoot::assign(const SE2& T_foot_floor) {
  std::fill(newest_.begin(), newest_.end(), Place{});
  const auto last = static_cast<double>(newest_.size() - 1);
  for (const Known& known : known_) {
    const Eigen::Vector2d p = T_foot_floor * known.p_floor;
    const double beam = grid_.beam(p);
    if (beam > -0.5 && beam < last + 0.5)
      newest_[static_cast<std::size_t>(std::lround(std::clamp(beam, 0.0, last)))] = {
          p.norm(), known.sure, known.foot};
  }
}

bool RememberedFoot::knownAt(int beam, const BeamChoice& choice) const {
  const Place& place = newest_[static_cast<std::size_t>(beam)];
  return place.distance > 0.0 &&
         std::abs(grid_.candidate(place.distance) - choice.candidate) < same_place;
}

void RememberedFoot::remember(const ComparedFrame& frame, const SE2& T_floor_foot, double seconds,
                              const std::vector<BeamChoice>& choices) {
  const double since = known_.empty() ? parameters_.foot_memory : seconds - known_.back().seconds;
  if (since < parameters_.foot_memory / most_frames) return;
  for (std::size_t beam = 0; beam < choices.size(); ++beam) {
    const BeamChoice& choice = choices[beam];
    if (!choice.any()) continue;
    const int b = static_cast<int>(beam);
    const float contrast = FootEdge::contrastAt(frame, b, choice);
    if (std::abs(contrast) < static_cast<float>(parameters_.foot_contrast)) continue;
    if (known_.size() == known_.capacity())
      known_.erase(known_.begin(),
                   known_.begin() + static_cast<std::ptrdiff_t>(known_.size() / 8 + 1));
    const int support = static_cast<int>(frame.sweep.sweepRow(choice.candidate)) - choice.top;
    known_.push_back({T_floor_foot * grid_.point(b, double{choice.candidate}),
                      seconds,
                      !choice.doubtful && (!choice.by_edge || knownAt(b, choice)),
                      {contrast, choice.score, support}});
  }
}

void RememberedFoot::complete(const ComparedFrame& frame, const SE2& T_floor_foot, double seconds,
                              bool new_evidence, std::vector<BeamChoice>& choices) {
  if (parameters_.foot_memory <= 0.0 || choices.size() != newest_.size()) return;
  forget(seconds);
  assign(T_floor_foot.inverse());
  if (new_evidence) remember(frame, T_floor_foot, seconds, choices);
  for (std::size_t beam = 0; beam < choices.size(); ++beam) {
    const Place& place = newest_[beam];
    if (choices[beam].any() || !place.sure) continue;
    choices[beam] =
        edge_.find(frame, place.foot, static_cast<int>(beam), grid_.candidate(place.distance));
  }
}

}  // namespace ipm_mapping::sweep
