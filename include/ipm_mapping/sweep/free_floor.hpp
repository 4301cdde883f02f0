#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"

namespace ipm_mapping::sweep {

/// What of the floor that looks like floor may be called free. Plain parts of an obstacle look like
/// floor too, so its neighbourhood decides:
///  - beside a contact nothing farther is free (`free_halo` beams),
///  - between two contacts closer together than `free_gap` nothing behind their line is free,
///  - what stood in the way and has passed below the image still stands there, along the whole line
///    between its contacts (`near_memory`).
/// A beam that sees no floor although both its neighbours do looks along a joint of the tiles: it
/// is as free as they are.
class FreeFloor {
 public:
  void configure(const FreeFloorParameters& parameters);
  void reset() { remembered_.clear(); }
  /// Remembers what another one does.
  void adopt(const FreeFloor& other) { remembered_ = other.remembered_; }

  /// Limits the free bearings of a frame by its contacts. Ranges count from the camera's foot;
  /// `near` of each bearing has to be set.
  void limit(Obstacles& obstacles) const;
  /// The same by earlier contacts that are below the view now, and remembers this frame's.
  /// `T_floor_base` is the pose of the base by the floor's own motion; `seconds` count up, but not
  /// while the robot stands.
  void limitBelowTheView(const SE2& T_floor_base, double seconds, Obstacles& obstacles);

 private:
  struct Remembered {
    Eigen::Vector2d p_floor;
    Eigen::Vector2d next_floor;  ///< of the contact beside it: coming nearer, they move apart
    double seconds;              ///< not counting those in which the robot stood
    double stamp;
  };
  void fillSlits(std::vector<Bearing>& bearings) const;
  void besideContacts(Obstacles& obstacles) const;
  void betweenContacts(Obstacles& obstacles) const;
  void belowTheView(const SE2& T_floor_base, double seconds, Obstacles& obstacles);
  void remember(const SE2& T_floor_base, double seconds, const Obstacles& obstacles);
  [[nodiscard]] Remembered& slotFor(const Remembered& line);

  FreeFloorParameters parameters_;
  std::vector<Remembered> remembered_;
};

}  // namespace ipm_mapping::sweep
