#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/detectors/contact_confirmation.hpp"
#include "ipm_mapping/parameters/memory_parameters.hpp"

namespace ipm_mapping {

/// What one used frame saw, to be asked about places in the odometry frame.
class RememberedView {
 public:
  /// Takes an answer; allocates only while the number of bearings grows.
  void assign(const Obstacles& seen);

  [[nodiscard]] const GroundView& ground() const { return ground_; }
  [[nodiscard]] double maxRange() const { return max_range_; }
  /// Seconds since the last new evidence: this view's, or that before it where the robot stood.
  [[nodiscard]] float ageAt(double stamp) const {
    return age_ + static_cast<float>(stamp - ground_.stamp);
  }
  [[nodiscard]] const std::vector<Bearing>& bearings() const { return bearings_; }
  [[nodiscard]] const std::vector<Contact>& contacts() const { return contacts_; }

  /// It is that of a robot that stood.
  [[nodiscard]] bool looksOn() const { return age_ > 0.0F; }
  /// Takes contacts of the same bearings in place of its own, with their ages.
  void carry(const std::vector<Contact>& contacts) {
    contacts_.assign(contacts.begin(), contacts.end());
  }

  /// Index of the bearing in whose sector a direction in base lies; nothing outside of the view.
  [[nodiscard]] std::optional<std::size_t> bearingAt(double angle) const;
  /// Whether the floor at a place was seen as floor; nothing where this view did not look.
  [[nodiscard]] std::optional<bool> floorAt(const Eigen::Vector2d& p_odom) const;

 private:
  GroundView ground_;
  SE2 T_base_odom_;
  double max_range_ = 0.0;
  float age_ = 0.0F;
  double middle_ = 0.0;          // angle of the middle bearing: offsets from it do not wrap
  std::vector<double> offsets_;  // of the bearings, from left to right: falling
  std::vector<Bearing> bearings_;
  std::vector<Contact> contacts_;
};

/// Holds what was seen while the robot shows nothing new: the last contacts and free floor, moved
/// into the present view, with growing age. The scene is taken to be static for that long, but for
/// what moves: that is only where the last frame saw it, and no longer than free floor. What a
/// robot that stands and looks on sees is the newest of it.
///
/// Of several frames that looked at a place the newest decides: a contact stays as long as no newer
/// frame saw floor there, and floor is free along a bearing as far as all of it was seen free.
class ContactMemory {
 public:
  explicit ContactMemory(const MemoryParameters& parameters = {})
      : parameters_(parameters), confirmation_(parameters) {}

  /// Clock or odometry jumped, or another camera.
  void clear();
  /// After a detector's frame. Confirms its answer where the filter is on, and remembers it. Where
  /// that is nothing new: fills `obstacles` with what still holds, its age and its contacts' ages
  /// above 0.
  /// Returns whether `obstacles` says something.
  bool follow(const Frame& frame, FrameStatus status, Obstacles& obstacles);

 private:
  static constexpr int capacity = 8;  // views

  [[nodiscard]] std::size_t slot(int back) const {
    return static_cast<std::size_t>((next_ - 1 - back + 2 * capacity) % capacity);
  }
  [[nodiscard]] const RememberedView& view(int back) const;
  [[nodiscard]] RememberedView& latest() { return views_[slot(0)]; }
  void remember(const Obstacles& seen);
  bool recall(const Frame& frame, Obstacles& obstacles) const;
  [[nodiscard]] bool holds(int back, const Frame& frame, double seconds) const;
  [[nodiscard]] bool isFree(const Frame& frame, const Eigen::Vector2d& p_base) const;
  [[nodiscard]] Bearing floorAlong(const Frame& frame, const Bearing& now) const;
  [[nodiscard]] bool blockedTowards(const Frame& frame, double angle) const;
  [[nodiscard]] bool refuted(int back, const Eigen::Vector2d& p_odom) const;
  void recallContacts(const Frame& frame, int back, Obstacles& obstacles) const;

  MemoryParameters parameters_;
  ContactConfirmation confirmation_;
  std::array<RememberedView, capacity> views_;  // ring
  int next_ = 0, known_ = 0;
};

}  // namespace ipm_mapping
