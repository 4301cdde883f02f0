#include "ipm_mapping/sweep/free_floor.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ipm_mapping::sweep {
namespace {

constexpr std::size_t most_remembered = 512;
constexpr int beside = 2;            // beams between contacts of one thing
constexpr double seen_again = 1.05;  // of the near end of the view
constexpr double flicker = 1.0;      // seconds for which a contact in view may go unseen
constexpr double same_place = 0.01;  // metres between two sights of a contact

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Eigen::Vector2d fromFoot(const Obstacles& obstacles, const Contact& contact) {
  return contact.p_base.cast<double>() - obstacles.view.cameraFoot();
}

/// Where a point lies among the bearings, fractions allowed, also beside the view; nothing for what
/// lies behind it.
std::optional<double> indexOf(const std::vector<Bearing>& bearings, const Eigen::Vector2d& p) {
  if (bearings.size() < 2) return std::nullopt;
  const double first = bearings.front().angle, step = bearings[1].angle - first;
  const double middle = 0.5 * static_cast<double>(bearings.size() - 1);
  const double off = wrapAngle(std::atan2(p.y(), p.x()) - (first + middle * step));
  if (std::abs(off) > M_PI_2) return std::nullopt;
  return middle + off / step;
}

/// The bearing next to such a place; -1 beside the view.
int bearingAt(const std::vector<Bearing>& bearings, double index) {
  const auto i = static_cast<int>(std::lround(index));
  return i >= 0 && i < static_cast<int>(bearings.size()) ? i : -1;
}

/// Distance at which a bearing between two points meets the line through them.
double crossing(const Bearing& bearing, const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  const Eigen::Vector2d ray(std::cos(bearing.angle), std::sin(bearing.angle));
  const double along = cross(ray, q - p);
  return std::abs(along) > 1e-9 ? cross(p, q - p) / along : std::min(p.norm(), q.norm());
}

/// A line from p to q, seen at places i to j; what of it is nearer than the view hides the floor
/// behind it.
void block(std::vector<Bearing>& bearings, double i, const Eigen::Vector2d& p, double j,
           const Eigen::Vector2d& q) {
  if (j < i) return block(bearings, j, q, i, p);
  const int from = std::max(0, static_cast<int>(std::lround(i)));
  const int to = std::min(static_cast<int>(bearings.size()) - 1, static_cast<int>(std::lround(j)));
  for (int k = from; k <= to; ++k) {
    Bearing& bearing = bearings[static_cast<std::size_t>(k)];
    if (bearing.state != BearingState::Free && bearing.state != BearingState::Unknown) continue;
    const double distance = k <= i ? p.norm() : k >= j ? q.norm() : crossing(bearing, p, q);
    if (distance > seen_again * bearing.near) continue;
    bearing.state = BearingState::Blocked;
    bearing.range = 0.0F;
  }
}

void shorten(Bearing& bearing, double range) {
  if (bearing.state == BearingState::Free)
    bearing.range = std::min(bearing.range, static_cast<float>(range));
}

}  // namespace

void FreeFloor::configure(const FreeFloorParameters& parameters) {
  parameters_ = parameters;
  remembered_.clear();
  remembered_.reserve(most_remembered);
}

void FreeFloor::fillSlits(std::vector<Bearing>& bearings) const {
  for (std::size_t i = 1; i + 1 < bearings.size(); ++i) {
    const Bearing &left = bearings[i - 1], &right = bearings[i + 1];
    if (bearings[i].state != BearingState::Unknown || left.state != BearingState::Free ||
        right.state != BearingState::Free)
      continue;
    bearings[i].state = BearingState::Free;
    bearings[i].range = std::min(left.range, right.range);
  }
}

void FreeFloor::besideContacts(Obstacles& obstacles) const {
  const int count = static_cast<int>(obstacles.bearings.size());
  for (const Contact& contact : obstacles.contacts) {
    const float range = obstacles.bearings[static_cast<std::size_t>(contact.bearing)].range;
    const int first = std::max(0, contact.bearing - parameters_.free_halo);
    const int last = std::min(count - 1, contact.bearing + parameters_.free_halo);
    for (int i = first; i <= last; ++i)
      shorten(obstacles.bearings[static_cast<std::size_t>(i)], range);
  }
}

void FreeFloor::betweenContacts(Obstacles& obstacles) const {
  for (std::size_t k = 1; k < obstacles.contacts.size(); ++k) {
    const Contact &a = obstacles.contacts[k - 1], &b = obstacles.contacts[k];
    const Eigen::Vector2d p = fromFoot(obstacles, a), q = fromFoot(obstacles, b);
    if (!((q - p).norm() < parameters_.free_gap)) continue;
    for (int i = a.bearing + 1; i < b.bearing; ++i) {
      Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(i)];
      shorten(bearing, crossing(bearing, p, q));
    }
  }
}

/// What is remembered in front of the view's near end hides the floor behind it.
void FreeFloor::belowTheView(const SE2& T_floor_base, double seconds, Obstacles& obstacles) {
  const SE2 T_base_floor = T_floor_base.inverse();
  const Eigen::Vector2d foot = obstacles.view.cameraFoot();
  const auto gone = [&](const Remembered& point) {
    const double age = seconds - point.seconds;
    if (age > parameters_.near_memory) return true;
    const Eigen::Vector2d p = T_base_floor * point.p_floor - foot;
    const Eigen::Vector2d q = T_base_floor * point.next_floor - foot;
    const auto i = indexOf(obstacles.bearings, p), j = indexOf(obstacles.bearings, q);
    if (!i || !j) return false;
    const int seen = bearingAt(obstacles.bearings, *i);
    if (seen >= 0 &&
        p.norm() > seen_again * obstacles.bearings[static_cast<std::size_t>(seen)].near)
      return obstacles.view.stamp - point.stamp > flicker;
    block(obstacles.bearings, *i, p, *j, q);
    return false;
  };
  remembered_.erase(std::remove_if(remembered_.begin(), remembered_.end(), gone),
                    remembered_.end());
}

/// That of the same line in an earlier frame, or room for it: that of the oldest where there is no
/// more. Lines of one frame lie closer together, and each of them counts.
FreeFloor::Remembered& FreeFloor::slotFor(const Remembered& line) {
  const auto same = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return (p - q).squaredNorm() < same_place * same_place;
  };
  const auto known = std::find_if(remembered_.begin(), remembered_.end(), [&](const auto& other) {
    return other.stamp < line.stamp && same(other.p_floor, line.p_floor) &&
           same(other.next_floor, line.next_floor);
  });
  if (known != remembered_.end()) return *known;
  if (remembered_.size() < most_remembered) return remembered_.emplace_back();
  return *std::min_element(remembered_.begin(), remembered_.end(),
                           [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
}

void FreeFloor::remember(const SE2& T_floor_base, double seconds, const Obstacles& obstacles) {
  const std::vector<Contact>& contacts = obstacles.contacts;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Contact& contact = contacts[k];
    const Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(contact.bearing)];
    if (contact.moving || bearing.range > 2.0F * bearing.near) continue;
    const Contact& next = contacts[std::min(k + 1, contacts.size() - 1)];
    const bool goes_on = !next.moving && next.bearing <= contact.bearing + beside &&
                         (next.p_base - contact.p_base).norm() < parameters_.free_gap;
    const Remembered line{
        T_floor_base * Eigen::Vector2d(contact.p_base.cast<double>()),
        T_floor_base * Eigen::Vector2d((goes_on ? next : contact).p_base.cast<double>()), seconds,
        obstacles.view.stamp};
    slotFor(line) = line;
  }
}

void FreeFloor::limit(Obstacles& obstacles) const {
  fillSlits(obstacles.bearings);
  besideContacts(obstacles);
  betweenContacts(obstacles);
}

void FreeFloor::limitBelowTheView(const SE2& T_floor_base, double seconds, Obstacles& obstacles) {
  if (parameters_.near_memory <= 0.0) return;
  belowTheView(T_floor_base, seconds, obstacles);
  remember(T_floor_base, seconds, obstacles);
}

}  // namespace ipm_mapping::sweep
