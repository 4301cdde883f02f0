#include "ipm_mapping/detectors/contact_confirmation.hpp"

#include <algorithm>

namespace ipm_mapping {
namespace {

/// The detector knows it from frames before.
bool held(const Contact& contact) { return contact.age > 0.0F; }

Eigen::Vector2d placeOf(const Contact& contact, const Obstacles& obstacles) {
  return obstacles.view.T_odom_base * contact.p_base.cast<double>();
}

/// A held contact may stand behind what its bearing says of the floor.
void withdraw(Bearing& bearing) {
  if (bearing.state == BearingState::Occupied) bearing.state = BearingState::Unknown;
}

}  // namespace

ContactConfirmation::ContactConfirmation(const MemoryParameters& parameters)
    : parameters_(parameters), frames_(static_cast<std::size_t>(parameters.confirm_of)) {}

bool ContactConfirmation::confirmed(const Eigen::Vector2d& p_odom) const {
  const double radius2 = parameters_.confirm_radius * parameters_.confirm_radius;
  const auto shows_it = [&](const Points& frame) {
    return std::any_of(frame.begin(), frame.end(), [&](const Eigen::Vector2d& p) {
      return (p - p_odom).squaredNorm() <= radius2;
    });
  };
  const auto end = frames_.begin() + static_cast<std::ptrdiff_t>(known_);
  return std::count_if(frames_.begin(), end, shows_it) >= parameters_.confirm_frames;
}

void ContactConfirmation::remember() {
  Points& frame = frames_[next_];
  frame.reserve(seen_.capacity());
  frame.assign(seen_.begin(), seen_.end());
  next_ = (next_ + 1) % frames_.size();
  known_ = std::min(known_ + 1, frames_.size());
}

void ContactConfirmation::apply(Obstacles& obstacles) {
  if (!parameters_.filter) return;
  seen_.clear();
  seen_.reserve(obstacles.bearings.size());
  for (const Contact& contact : obstacles.contacts)
    if (!held(contact)) seen_.push_back(placeOf(contact, obstacles));
  if (!(obstacles.age > 0.0F)) remember();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < obstacles.contacts.size(); ++i) {
    const Contact& contact = obstacles.contacts[i];
    if (contact.moving || confirmed(placeOf(contact, obstacles)))
      obstacles.contacts[kept++] = contact;
    else
      withdraw(obstacles.bearings[static_cast<std::size_t>(contact.bearing)]);
  }
  obstacles.contacts.resize(kept);
}

}  // namespace ipm_mapping
