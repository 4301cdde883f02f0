#include "ipm_mapping/detectors/contact_memory.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace ipm_mapping {
namespace {

constexpr double floor_step = 0.05;  // metres between the places asked along a bearing
constexpr int late_steps = 3;        // of it, by which the floor may begin later than the view
constexpr int halvings = 7;          // of that step, to find where free floor ends
constexpr double rounding = 1e-4;    // metres
constexpr double own_turn = 0.2;     // radians: views turned less replace one another
constexpr float least_age = 1e-6F;   // seconds: above 0 means remembered

bool nothingNew(FrameStatus status) {
  return status == FrameStatus::Watched || status == FrameStatus::NoMotion ||
         status == FrameStatus::NoReference || status == FrameStatus::TooMuchRotation;
}

double distanceBetween(const SE2& a, const SE2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

Eigen::Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Makes a contact the one of its bearing, `range` from the camera's foot, unless a nearer one is.
void place(const Contact& contact, float range, Obstacles& obstacles) {
  Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(contact.bearing)];
  const bool taken = bearing.state == BearingState::Occupied;
  if (taken && bearing.range <= range) return;
  const bool floor_seen = bearing.state == BearingState::Free &&
                          bearing.range >= range - static_cast<float>(floor_step);
  // What nobody saw in front of it is not free.
  bearing.near = taken || floor_seen ? std::min(bearing.near, range) : range;
  bearing.state = BearingState::Occupied;
  bearing.range = range;
  bearing.density = contact.score;
  const auto same =
      std::find_if(obstacles.contacts.begin(), obstacles.contacts.end(),
                   [&](const Contact& other) { return other.bearing == contact.bearing; });
  if (same == obstacles.contacts.end())
    obstacles.contacts.push_back(contact);
  else
    *same = contact;
}

}  // namespace

void RememberedView::assign(const Obstacles& seen) {
  ground_ = seen.view;
  T_base_odom_ = seen.view.T_odom_base.inverse();
  max_range_ = seen.max_range;
  age_ = seen.age;
  bearings_.assign(seen.bearings.begin(), seen.bearings.end());
  contacts_.reserve(bearings_.size());
  contacts_.assign(seen.contacts.begin(), seen.contacts.end());
  offsets_.clear();
  if (bearings_.empty()) return;
  middle_ = bearings_[bearings_.size() / 2].angle;
  for (const Bearing& bearing : bearings_)
    offsets_.push_back(wrapAngle(double{bearing.angle} - middle_));
}

std::optional<std::size_t> RememberedView::bearingAt(double angle) const {
  const std::size_t count = offsets_.size();
  if (count < 2) return std::nullopt;
  const double offset = wrapAngle(angle - middle_);
  const auto next = std::lower_bound(offsets_.begin(), offsets_.end(), offset, std::greater<>());
  auto i = static_cast<std::size_t>(next - offsets_.begin());
  if (i == count || (i > 0 && offsets_[i - 1] - offset < offset - offsets_[i])) --i;
  const double gap = offsets_[i > 0 ? i - 1 : 0] - offsets_[i > 0 ? i : 1];
  if (std::abs(offset - offsets_[i]) > 0.5 * gap + 1e-9) return std::nullopt;
  return i;
}

std::optional<bool> RememberedView::floorAt(const Eigen::Vector2d& p_odom) const {
  const Eigen::Vector2d p_base = T_base_odom_ * p_odom;
  const Eigen::Vector2d from_foot = p_base - ground_.cameraFoot();
  const auto i = bearingAt(std::atan2(from_foot.y(), from_foot.x()));
  if (!i || p_base.norm() > max_range_ + floor_step) return std::nullopt;
  const Bearing& bearing = bearings_[*i];
  const double distance = from_foot.norm();
  if (distance < double{bearing.near} - rounding) return std::nullopt;
  return bearing.state != BearingState::Unknown && distance <= double{bearing.range} + rounding;
}

void ContactMemory::clear() {
  known_ = 0;
  confirmation_.clear();
}

bool ContactMemory::follow(const Frame& frame, FrameStatus status, Obstacles& obstacles) {
  const bool watched = status == FrameStatus::Watched;
  if (status == FrameStatus::Used || watched) {
    confirmation_.apply(obstacles);
    if (parameters_.hold > 0.0) remember(obstacles);
    if (!watched || !(parameters_.hold > 0.0)) return true;
  }
  if (!nothingNew(status) || !recall(frame, obstacles)) return false;
  if (watched) latest().carry(obstacles.contacts);  // older views of a long stop go
  return true;
}

/// 0: the newest.
const RememberedView& ContactMemory::view(int back) const { return views_[slot(back)]; }

/// The newest view is always kept; of the ones before it, one for every piece of the way or turn,
/// and the one before of a robot that looks on.
void ContactMemory::remember(const Obstacles& seen) {
  if (known_ >= 2 && seen.age > 0.0F && view(0).looksOn()) {
    if (view(1).looksOn()) {
      std::swap(views_[slot(0)], views_[slot(1)]);
      next_ = (next_ + capacity - 1) % capacity;
      --known_;
    }
  } else if (known_ >= 2) {
    const SE2 &a = view(0).ground().T_odom_base, &b = view(1).ground().T_odom_base;
    const bool alike = distanceBetween(a, b) < parameters_.hold_distance / (capacity - 2) &&
                       std::abs(wrapAngle(a.theta - b.theta)) < own_turn;
    if (alike) {
      next_ = (next_ + capacity - 1) % capacity;
      --known_;
    }
  }
  views_[static_cast<std::size_t>(next_)].assign(seen);
  next_ = (next_ + 1) % capacity;
  known_ = std::min(known_ + 1, capacity);
}

bool ContactMemory::holds(int back, const Frame& frame, double seconds) const {
  const GroundView& seen = view(back).ground();
  return frame.stamp - seen.stamp <= seconds &&
         distanceBetween(frame.T_odom_base, seen.T_odom_base) <= parameters_.hold_distance;
}

bool ContactMemory::recall(const Frame& frame, Obstacles& obstacles) const {
  int newest = 0;
  while (newest < known_ && !holds(newest, frame, parameters_.hold)) ++newest;
  obstacles.clear();
  if (newest == known_) return false;
  const RememberedView& last = view(0);
  obstacles.frame = frame.index;
  obstacles.max_range = last.maxRange();
  obstacles.view = last.ground();
  obstacles.view.stamp = frame.stamp;
  obstacles.view.T_odom_base = frame.T_odom_base;
  obstacles.age = std::max(least_age, view(newest).ageAt(frame.stamp));
  obstacles.contacts.reserve(last.bearings().size());
  for (const Bearing& bearing : last.bearings())
    obstacles.bearings.push_back(floorAlong(frame, bearing));
  for (int back = newest; back < known_; ++back)
    if (holds(back, frame, parameters_.hold)) recallContacts(frame, back, obstacles);
  return true;
}

/// As the newest frame that looked at the place says.
bool ContactMemory::isFree(const Frame& frame, const Eigen::Vector2d& p_base) const {
  const Eigen::Vector2d p_odom = frame.T_odom_base * p_base;
  for (int back = 0; back < known_; ++back) {
    if (!holds(back, frame, parameters_.hold_free)) continue;
    if (const auto floor = view(back).floorAt(p_odom)) return *floor;
  }
  return false;
}

/// Follows the floor outwards, from where the view begins, as long as it is known to be free. The
/// view of another place may begin a little farther out.
Bearing ContactMemory::floorAlong(const Frame& frame, const Bearing& now) const {
  const RememberedView& last = view(0);
  const Eigen::Vector2d foot = last.ground().cameraFoot(), ahead = direction(double{now.angle});
  const auto free_at = [&](double range) {
    const Eigen::Vector2d p_base = foot + range * ahead;
    return p_base.norm() <= last.maxRange() && isFree(frame, p_base);
  };
  Bearing bearing;
  bearing.angle = now.angle;
  if (blockedTowards(frame, double{now.angle})) {
    bearing.state = BearingState::Blocked;
    return bearing;
  }
  double range = double{now.near};
  if (!(range > 0.0))
    range = nearestVisibleFloor(last.ground().camera, last.ground().T_base_camera);
  for (int i = 0; i < late_steps && !free_at(range); ++i) range += floor_step;
  if (!free_at(range)) return bearing;
  bearing.near = static_cast<float>(range);
  while (free_at(range + floor_step)) range += floor_step;
  for (double step = 0.5 * floor_step, i = 0; i < halvings; ++i, step *= 0.5)
    if (free_at(range + step)) range += step;
  bearing.state = BearingState::Free;
  bearing.range = static_cast<float>(range);
  return bearing;
}

bool ContactMemory::blockedTowards(const Frame& frame, double angle) const {
  for (int back = 0; back < known_; ++back) {
    if (!holds(back, frame, parameters_.hold)) continue;
    const double turned = frame.T_odom_base.theta - view(back).ground().T_odom_base.theta;
    if (const auto i = view(back).bearingAt(angle + turned))
      return view(back).bearings()[*i].state == BearingState::Blocked;
  }
  return false;
}

/// A newer frame saw floor where a contact of view `back` was.
bool ContactMemory::refuted(int back, const Eigen::Vector2d& p_odom) const {
  for (int newer = 0; newer < back; ++newer)
    if (view(newer).floorAt(p_odom).value_or(false)) return true;
  return false;
}

void ContactMemory::recallContacts(const Frame& frame, int back, Obstacles& obstacles) const {
  const GroundView& seen = view(back).ground();
  const SE2 T_now_seen = frame.T_odom_base.inverse() * seen.T_odom_base;
  const GroundProjection floor = obstacles.view.currentFloor();
  for (Contact contact : view(back).contacts()) {
    // once only: where it was before, it is not any more
    if (contact.moving && (back > 0 || !holds(back, frame, parameters_.hold_free))) continue;
    const Eigen::Vector2d p_seen = contact.p_base.cast<double>();
    if (refuted(back, seen.T_odom_base * p_seen)) continue;
    const Eigen::Vector2d p_base = T_now_seen * p_seen;
    const Eigen::Vector2d from_foot = p_base - seen.cameraFoot();
    const auto bearing = view(0).bearingAt(std::atan2(from_foot.y(), from_foot.x()));
    if (!bearing || p_base.norm() > obstacles.max_range) continue;
    contact.bearing = static_cast<int>(*bearing);
    contact.p_base = p_base.cast<float>();
    contact.age = std::max(least_age, contact.age + static_cast<float>(frame.stamp - seen.stamp));
    if (double{contact.age} > parameters_.hold) continue;
    const Eigen::Vector2d pixel = floor.pixel(p_base).value_or(Eigen::Vector2d::Zero());
    contact.u = static_cast<float>(pixel.x());
    contact.v = static_cast<float>(pixel.y());
    place(contact, static_cast<float>(from_foot.norm()), obstacles);
  }
}

}  // namespace ipm_mapping
