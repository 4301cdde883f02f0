#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/geometry/vanishing_point.hpp"

namespace ipm_mapping {

/// What one bearing of one frame says.
enum class BearingState : std::uint8_t {
  Unknown,   ///< too little floor was seen
  Free,      ///< floor seen up to `range`
  Occupied,  ///< an obstacle meets the floor at `range`
  Blocked    ///< an obstacle whose foot is not in view: occupied, free floor only up to `range`
};
[[nodiscard]] const char* name(BearingState state);

/// One direction on the floor, seen from the foot point of the camera.
struct Bearing {
  float angle = 0.0F;    ///< in base axes, left positive, radians
  float density = 0.0F;  ///< share of obstacle pixels on the line, or the beam's score
  float range = 0.0F;    ///< metres from the camera's foot point, see `state`
  float near = 0.0F;  ///< metres from there at which the floor comes into view: not seen before it
  BearingState state = BearingState::Unknown;
};

/// A point where an obstacle meets the floor.
struct Contact {
  int bearing = 0;               ///< index into Obstacles::bearings
  float u = 0.0F, v = 0.0F;      ///< undistorted pixel of the current image
  Eigen::Vector2f p_base{0, 0};  ///< on the floor, in base, metres
  float score = 0.0F;            ///< evidence; its unit is the detector's
  float height = 0.0F;       ///< height of the support above the contact, metres; 0: not measured
  float range_sigma = 0.0F;  ///< standard deviation along the bearing, metres; 0: not estimated
  float age = 0.0F;          ///< seconds since it was last seen (0: in this frame)
  bool moving = false;       ///< has come onto floor that was free a moment ago
};

/// A detector's answer for one frame.
struct Obstacles {
  std::uint64_t frame = 0;  ///< index of the camera frame
  GroundView view;          ///< geometry it was made with
  Focus focus;              ///< where the beam starts
  double max_range = 0.0;   ///< metres from the base origin that were looked at
  float age = 0.0F;  ///< seconds since the last new evidence (0: this frame): more is for no map
  float separability = 0.0F;        ///< how clearly obstacle and floor differ, 0..1
  int threshold = -1;               ///< grey levels; -1: the detector has none
  std::vector<Bearing> bearings;    ///< from the left of the view to the right
  std::vector<Contact> contacts;    ///< selected: what the map is built from
  std::vector<Contact> candidates;  ///< all that was found, before selection

  void clear() {
    max_range = 0.0;
    age = 0.0F;
    bearings.clear();
    contacts.clear();
    candidates.clear();
    separability = 0.0F;
    threshold = -1;
  }
};

}  // namespace ipm_mapping
