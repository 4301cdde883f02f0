#include "ipm_mapping/sweep/held_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ipm_mapping::sweep {
namespace {

constexpr double never = -std::numeric_limits<double>::infinity();
constexpr double between_looks = 0.25;  // seconds: from frame to frame a mistake is the same
constexpr double same_place = 5.0;      // candidates between sights
constexpr double seen_through = 3.0;    // by which free floor reaches farther
constexpr int lowest_face = 3;          // rows above the foot
constexpr int least_rows = 4;           // of a face that is cut off by the view

/// Mean grey level of a beam in one row.
float greyAt(const ComparedFrame& frame, int beam, int row) {
  constexpr float unit = 1.0F / (kernels::beam_lines * kernels::grey_unit);
  const std::int32_t* sum = frame.current.sums.row(beam);
  return static_cast<float>(sum[row + 1] - sum[row]) * unit;
}

}  // namespace

void HeldContact::configure(const VerticalSweep& sweep, const FootParameters& parameters) {
  parameters_ = parameters;
  grid_ = sweep.scoreGrid();
  const auto beams = static_cast<std::size_t>(sweep.beams());
  const auto looks = static_cast<std::size_t>(parameters.hold_memory / between_looks) + 1;
  reset();
  sights_.reserve(looks * beams);
  places_.assign(beams, Place{});
  held_.assign(beams, Held{});
}

void HeldContact::reset() {
  sights_.clear();
  looked_ = never;
}

void HeldContact::forget(double stamp) {
  const auto old = [&](const Sight& s) { return stamp - s.stamp > parameters_.hold_memory; };
  sights_.erase(std::remove_if(sights_.begin(), sights_.end(), old), sights_.end());
}

void HeldContact::count(Place& place, double candidate, int sight) const {
  const int look = sights_[static_cast<std::size_t>(sight)].look;
  if (place.newest < 0) {
    place = {sight, candidate, 1, look};
  } else if (look != place.last_look && std::abs(candidate - place.candidate) < same_place) {
    ++place.sights;
    place.last_look = look;
  }
}

/// From the newest sight to the oldest: the newest of a beam says where, the others how often.
void HeldContact::assign(const SE2& T_foot_floor, bool new_evidence, const Obstacles& answer) {
  std::fill(places_.begin(), places_.end(), Place{});
  const auto end = static_cast<double>(places_.size()) - 0.5;
  for (int i = static_cast<int>(sights_.size()) - 1; i >= 0; --i) {
    Sight& sight = sights_[static_cast<std::size_t>(i)];
    const Eigen::Vector2d p = T_foot_floor * sight.p_floor;
    const double beam = grid_.beam(p);
    if (!(beam > -0.5 && beam < end)) continue;
    const auto nearest = static_cast<std::size_t>(std::lround(beam));
    const double candidate = grid_.candidate(p.norm());
    const Bearing& bearing = answer.bearings[nearest];
    const bool is_floor = bearing.state == BearingState::Free &&
                          grid_.candidate(double{bearing.range}) < candidate - seen_through;
    if (!is_floor)
      count(places_[nearest], candidate, i);
    else if (new_evidence)
      sight.stamp = never;
  }
}

HeldContact::Face HeldContact::faceAt(const ComparedFrame& frame, int beam,
                                      const BeamChoice& choice) const {
  const RowRange seen = frame.sweep.rows(beam);
  const int foot = static_cast<int>(std::lround(frame.sweep.sweepRow(choice.candidate)));
  Face face;
  face.begin = std::max(-std::clamp(foot - choice.top, lowest_face, rows_above), seen.begin - foot);
  face.end = std::min(rows_below, seen.end - foot);
  for (int j = face.begin; j < face.end; ++j)
    face.grey[static_cast<std::size_t>(j - face.begin)] = greyAt(frame, beam, foot + j);
  return face;
}

bool HeldContact::looksAsBefore(const ComparedFrame& frame, int beam, double candidate,
                                const Face& before) const {
  const RowRange seen = frame.sweep.rows(beam);
  const int foot = static_cast<int>(std::lround(frame.sweep.sweepRow(candidate)));
  const int begin = std::max(before.begin, seen.begin - foot);
  const int end = std::min(before.end, seen.end - foot);
  if (end - begin < least_rows) return false;
  const auto rows = static_cast<float>(end - begin);
  const auto was = [&](int j) { return before.grey[static_cast<std::size_t>(j - before.begin)]; };
  const auto change = [&](int j) { return greyAt(frame, beam, foot + j) - was(j); };
  /// Sum of squares of what varies about its mean.
  const auto variation = [&](const auto& value) {
    float mean = 0.0F, sum = 0.0F;
    for (int j = begin; j < end; ++j) mean += value(j) / rows;
    for (int j = begin; j < end; ++j) sum += (value(j) - mean) * (value(j) - mean);
    return sum;
  };
  return variation(change) <= static_cast<float>(parameters_.hold_change) * variation(was);
}

void HeldContact::remember(const ComparedFrame& frame, const SE2& T_floor_foot,
                           const std::vector<BeamChoice>& choices, const Obstacles& answer) {
  if (answer.view.stamp - looked_ < between_looks) return;
  looked_ = answer.view.stamp;
  ++look_;
  for (const Contact& contact : answer.contacts) {
    const BeamChoice& choice = choices[static_cast<std::size_t>(contact.bearing)];
    if (choice.moving || sights_.size() == sights_.capacity()) continue;
    Sight sight;
    sight.p_floor = T_floor_foot * grid_.point(contact.bearing, double{choice.candidate});
    sight.stamp = answer.view.stamp;
    sight.look = look_;
    sight.score = choice.score;
    sight.curvature = choice.curvature;
    sight.support = static_cast<int>(frame.sweep.sweepRow(choice.candidate)) - choice.top;
    sight.face = faceAt(frame, contact.bearing, choice);
    sights_.push_back(sight);
  }
}

const std::vector<HeldContact::Held>& HeldContact::follow(const ComparedFrame& frame,
                                                          const SE2& T_floor_foot,
                                                          bool new_evidence,
                                                          const std::vector<BeamChoice>& choices,
                                                          const Obstacles& answer) {
  std::fill(held_.begin(), held_.end(), Held{});
  if (parameters_.hold_sights <= 0 || answer.bearings.size() != held_.size()) return held_;
  forget(answer.view.stamp);
  assign(T_floor_foot.inverse(), new_evidence, answer);
  for (std::size_t beam = 0; beam < held_.size(); ++beam) {
    const BearingState state = answer.bearings[beam].state;
    const Place& place = places_[beam];
    if ((state != BearingState::Free && state != BearingState::Unknown) ||
        place.sights < parameters_.hold_sights)
      continue;
    const Sight& sight = sights_[static_cast<std::size_t>(place.newest)];
    if (!looksAsBefore(frame, static_cast<int>(beam), place.candidate, sight.face)) continue;
    BeamChoice& choice = held_[beam].choice;
    choice.candidate = static_cast<float>(place.candidate);
    choice.score = sight.score;
    choice.curvature = sight.curvature;
    choice.top = static_cast<int>(frame.sweep.sweepRow(place.candidate)) - sight.support;
    held_[beam].stamp = sight.stamp;
  }
  if (new_evidence) remember(frame, T_floor_foot, choices, answer);
  return held_;
}

}  // namespace ipm_mapping::sweep
