#include "ipm_mapping/sweep/lone_contact.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr int beside = 2;                // beams to either side
constexpr double same_thing = 5.0;       // candidates between neighbours
constexpr double same_beams = 1.0;       // between two sights of one place
constexpr double same_candidates = 2.0;  // two per cent of its distance

}  // namespace

void LoneContact::configure(const VerticalSweep& sweep, const SelectionParameters& parameters) {
  lone_frames_ = std::min(parameters.lone_frames, parameters.lone_of);
  grid_ = sweep.scoreGrid();
  frames_.resize(static_cast<std::size_t>(std::max(1, parameters.lone_of - 1)));
  for (Points& frame : frames_) frame.reserve(static_cast<std::size_t>(sweep.beams()));
  reset();
}

bool LoneContact::alone(const std::vector<BeamChoice>& choices, int beam) const {
  const auto last = static_cast<int>(choices.size()) - 1;
  const BeamChoice& own = choices[static_cast<std::size_t>(beam)];
  for (int other = std::max(0, beam - beside); other <= std::min(last, beam + beside); ++other) {
    const BeamChoice& choice = choices[static_cast<std::size_t>(other)];
    if (other != beam && choice.any() &&
        std::abs(double{choice.candidate} - double{own.candidate}) <= same_thing)
      return false;
  }
  return true;
}

bool LoneContact::saw(const Points& frame, const SE2& T_foot_floor, int beam,
                      const BeamChoice& choice) const {
  return std::any_of(frame.begin(), frame.end(), [&](const Eigen::Vector2d& p_floor) {
    const Eigen::Vector2d p = T_foot_floor * p_floor;
    return std::abs(grid_.beam(p) - beam) <= same_beams &&
           std::abs(grid_.candidate(p.norm()) - double{choice.candidate}) <= same_candidates;
  });
}

void LoneContact::remember(const SE2& T_floor_foot, const std::vector<BeamChoice>& choices) {
  Points& frame = frames_[next_];
  next_ = (next_ + 1) % frames_.size();
  known_ = std::min(known_ + 1, frames_.size());
  frame.clear();
  for (std::size_t beam = 0; beam < choices.size(); ++beam)
    if (choices[beam].any())
      frame.push_back(T_floor_foot *
                      grid_.point(static_cast<double>(beam), double{choices[beam].candidate}));
}

void LoneContact::mark(const SE2& T_floor_foot, bool new_evidence,
                       std::vector<BeamChoice>& choices) {
  if (lone_frames_ <= 1) return;
  const SE2 T_foot_floor = T_floor_foot.inverse();
  const auto end = frames_.begin() + static_cast<std::ptrdiff_t>(known_);
  for (int beam = 0; beam < static_cast<int>(choices.size()); ++beam) {
    BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
    if (!choice.any() || !alone(choices, beam)) continue;
    const auto seen = std::count_if(frames_.begin(), end, [&](const Points& frame) {
      return saw(frame, T_foot_floor, beam, choice);
    });
    choice.doubtful = seen + (new_evidence ? 1 : 0) < lone_frames_;
  }
  if (new_evidence) remember(T_floor_foot, choices);
}

}  // namespace ipm_mapping::sweep
