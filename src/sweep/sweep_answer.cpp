// What the sweep found, as the message that everybody reads.
#include <algorithm>
#include <cmath>
#include <limits>

#include "ipm_mapping/geometry/vanishing_point.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping::sweep {

void SweepDetector::fillView(const Frame& frame, Obstacles& obstacles) const {
  obstacles.frame = frame.index;
  obstacles.max_range = max_range_;
  obstacles.age = static_cast<float>(std::max(0.0, current_.stamp - stopped_));
  GroundView& view = obstacles.view;
  view.stamp = frame.stamp;
  view.reference_stamp = references_[0]->stamp;
  view.camera = camera_;
  view.T_base_camera = T_base_camera_;
  view.T_odom_base = frame.T_odom_base;
}

/// Height of the support above the contact, metres.
double SweepDetector::heightOf(const BeamChoice& choice) const {
  const double r_top = grid_.r(choice.top * PolarGrid::rows_per_sweep_row);
  return grid_.height * std::max(0.0, 1.0 - r_top / sweep_.r(choice.candidate));
}

/// What the upper edge of the view cuts off may be higher.
void SweepDetector::doubtLowContacts() {
  for (int beam = 0; beam < sweep_.beams(); ++beam) {
    BeamChoice& choice = choices_[static_cast<std::size_t>(beam)];
    if (choice.any() && choice.top > sweep_.rows(beam).begin + 1 &&
        heightOf(choice) < parameters_.selection.least_height)
      choice.doubtful = true;
  }
}

/// Range variance: the sharpness of the score's maximum, then what calibration may be off. With
/// d = h / r: a pitch error p moves r by (1 + r^2) p, a height error e moves d by d e / h.
Contact SweepDetector::contactOf(int beam, const BeamChoice& choice) const {
  const double azimuth = sweep_.azimuth(beam), r = sweep_.r(choice.candidate);
  const double d = grid_.height / r;
  Contact contact;
  contact.bearing = beam;
  contact.p_base = (T_base_camera_.translation().head<2>() +
                    d * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth)))
                       .cast<float>();
  double u = 0.0, v = 0.0;
  if (undistortedPixel(camera_, T_base_camera_, azimuth, r, u, v)) {
    contact.u = static_cast<float>(u);
    contact.v = static_cast<float>(v);
  }
  contact.score = choice.score;
  contact.height = static_cast<float>(heightOf(choice));
  const CalibrationUncertainty& c = parameters_.uncertainty;
  const double step = PolarGrid::rows_per_sweep_row / grid_.rows_per_log * d;
  const double sharpness = std::max(static_cast<double>(-choice.curvature), c.least_sharpness);
  const double by_pixel = step / std::sqrt(sharpness);
  const double by_pitch = d * (1.0 + r * r) / r * c.sd_pitch;
  const double by_height = d / grid_.height * c.sd_height;
  contact.range_sigma = static_cast<float>(
      std::sqrt(by_pixel * by_pixel + by_pitch * by_pitch + by_height * by_height));
  contact.moving = choice.moving;
  return contact;
}

/// Follows the floor of one beam from the near end of the view outwards, while a window of rows
/// stays cheap in the eyes of one reference.
SweepDetector::FloorReach SweepDetector::floorReach(int beam, const SweepReference& view) const {
  const RowRange rows = sweep_.rows(beam);
  const int window = parameters_.free_floor.free_window;
  const double unit = static_cast<double>(kernels::cost_unit) * window;
  const std::uint16_t* cost = view.floor_cost.row(beam);
  FloorReach reach;
  int sum = 0, number = 0, row = rows.end - 1;
  for (; row >= rows.begin && cost[row] != kernels::no_cost; --row) {
    sum += cost[row];
    if (++number > window) sum -= cost[row + window];
    if (number == window) reach.nearest_cost = sum / unit;
    if (number >= window && sum > parameters_.free_floor.free_cost * unit) break;
  }
  if (number > window) reach.range = grid_.distance((row + window) * PolarGrid::rows_per_sweep_row);
  return reach;
}

/// What the floor alone says about a beam: free as far as every reference calls it floor, blocked
/// where none of them finds floor at the near end of the view.
Bearing SweepDetector::floorBearing(int beam) const {
  Bearing bearing;
  bearing.angle = static_cast<float>(sweep_.azimuth(beam));
  const int nearest_row = std::max(sweep_.rows(beam).end - 1, 0);
  bearing.near = static_cast<float>(grid_.distance(nearest_row * PolarGrid::rows_per_sweep_row));
  double range = rangeLimit(sweep_.azimuth(beam)), least_cost = 9.0;
  for (int q = 0; q < reference_count_; ++q) {
    const FloorReach reach = floorReach(beam, views_[static_cast<std::size_t>(q)]);
    range = std::min(range, reach.range);
    least_cost = std::min(least_cost, reach.nearest_cost);
  }
  bearing.range = static_cast<float>(range);
  if (range > 0.0) bearing.state = BearingState::Free;
  if (least_cost > parameters_.free_floor.blocked_cost) bearing.state = BearingState::Blocked;
  return bearing;
}

/// Distance of the nearest candidate in view that may be an obstacle, published or not; infinite
/// where there is none.
double SweepDetector::doubtfulDistance(int beam) const {
  const float* s = scores_.score.row(beam);
  const auto share = static_cast<float>(parameters_.selection.weak_share);
  const int in_view = sweep_.rows(beam).end - static_cast<int>(sweep_.sweepRow(0.0));
  for (int c = std::min(in_view, sweep_.candidates()) - 1; c >= 0; --c)
    if (s[c] > 0.0F && s[c] >= share * selection_.leastScore(c)) return sweep_.distance(c);
  return std::numeric_limits<double>::infinity();
}

void SweepDetector::fillCandidates(Obstacles& obstacles) const {
  const auto least = static_cast<float>(parameters_.selection.publish_score);
  for (int beam = 0; beam < sweep_.beams(); ++beam) {
    const float* s = scores_.score.row(beam);
    for (int c = 1; c + 1 < sweep_.candidates(); ++c) {
      if (s[c] < least || s[c] < s[c - 1] || !(s[c] > s[c + 1])) continue;
      BeamChoice choice;
      choice.candidate = static_cast<float>(c);
      choice.score = s[c];
      choice.curvature = s[c - 1] - 2.0F * s[c] + s[c + 1];
      choice.top = scores_.top.at(c, beam);
      obstacles.candidates.push_back(contactOf(beam, choice));
    }
  }
}

void SweepDetector::fillObstacles(const CurrentView& current, Obstacles& obstacles) {
  obstacles.view.motion = motions_[0].motion;
  obstacles.focus = midFootFocus(vanishingPoints(obstacles.view));
  floor_beams_ = 0;
  fillCandidates(obstacles);
  for (int beam = 0; beam < sweep_.beams(); ++beam) {
    const BeamChoice& choice = choices_[static_cast<std::size_t>(beam)];
    Bearing bearing = floorBearing(beam);
    if (bearing.state == BearingState::Free) ++floor_beams_;
    bearing.density = choice.score;
    const double limit = rangeLimit(sweep_.azimuth(beam));
    if (choice.any()) {
      const double d = sweep_.distance(choice.candidate);
      const int row = static_cast<int>(sweep_.sweepRow(choice.candidate));
      if (row + 1 >= sweep_.rows(beam).end) {
        bearing.state = choice.doubtful ? BearingState::Unknown : BearingState::Blocked;
        bearing.range = 0.0F;
      } else if (d <= limit) {
        bearing.state = BearingState::Occupied;
        bearing.range = static_cast<float>(d);
        obstacles.contacts.push_back(contactOf(beam, choice));
      } else {
        bearing.range = std::min(bearing.range, static_cast<float>(d));
      }
    }
    if (bearing.state == BearingState::Free)
      bearing.range = static_cast<float>(plain_edge_.limit(current, views_.data(), reference_count_,
                                                           sweep_, beam, double{bearing.range}));
    obstacles.bearings.push_back(bearing);
  }
  free_floor_.limit(obstacles);
  for (int beam = 0; beam < sweep_.beams(); ++beam) {
    Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(beam)];
    if (bearing.state == BearingState::Free)
      bearing.range = std::min(bearing.range, static_cast<float>(doubtfulDistance(beam)));
  }
  withdrawDoubtful(obstacles);
  free_floor_.limitBelowTheView(current_.T_floor_base, current_.stamp - stood_, obstacles);
}

/// They have kept the floor beside them from being called free; more they do not say yet.
void SweepDetector::withdrawDoubtful(Obstacles& obstacles) const {
  const auto doubtful = [&](const Contact& contact) {
    const auto beam = static_cast<std::size_t>(contact.bearing);
    if (!choices_[beam].doubtful) return false;
    obstacles.bearings[beam].state = BearingState::Unknown;
    return true;
  };
  auto& contacts = obstacles.contacts;
  contacts.erase(std::remove_if(contacts.begin(), contacts.end(), doubtful), contacts.end());
}

/// Bearings without a contact get what is held, and go on saying what they say of the floor: this
/// frame does not show what stands in front of it.
void SweepDetector::holdContacts(const ComparedFrame& frame, bool new_evidence,
                                 Obstacles& obstacles) {
  constexpr float least_age = 1e-6F;  // seconds: above 0 means remembered
  const auto& held =
      held_contact_.follow(frame, footAt(current_.T_floor_base), new_evidence, choices_, obstacles);
  const std::size_t seen = obstacles.contacts.size();
  for (int beam = 0; beam < sweep_.beams(); ++beam) {
    const auto& [choice, stamp] = held[static_cast<std::size_t>(beam)];
    if (!choice.any()) continue;
    const double range = sweep_.distance(choice.candidate);
    const double nearest = obstacles.bearings[static_cast<std::size_t>(beam)].near;
    if (range > rangeLimit(sweep_.azimuth(beam)) || range < nearest) continue;
    obstacles.contacts.push_back(contactOf(beam, choice));
    obstacles.contacts.back().age =
        std::max(least_age, static_cast<float>(obstacles.view.stamp - stamp));
  }
  const auto by_bearing = [](const Contact& a, const Contact& b) { return a.bearing < b.bearing; };
  std::inplace_merge(obstacles.contacts.begin(),
                     obstacles.contacts.begin() + static_cast<std::ptrdiff_t>(seen),
                     obstacles.contacts.end(), by_bearing);
}

/// Distance from the camera's foot at which a bearing leaves the circle of max_range around base.
double SweepDetector::rangeLimit(double azimuth) const {
  const Eigen::Vector2d foot = T_base_camera_.translation().head<2>();
  const double along = foot.x() * std::cos(azimuth) + foot.y() * std::sin(azimuth);
  const double rest = max_range_ * max_range_ - foot.squaredNorm() + along * along;
  return rest > 0.0 ? std::max(0.0, std::sqrt(rest) - along) : 0.0;
}

}  // namespace ipm_mapping::sweep
