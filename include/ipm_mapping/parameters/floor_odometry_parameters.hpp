#pragma once
// Parameters of the visual odometry on the floor.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

/// What the motion between two frames does not know of itself: errors that are the same all along a
/// drive add up where those of single frames average out.
struct FloorOdometryParameters {
  double sd_scale = 0.014;
  double sd_turn = 0.002;
  double sd_shift = 0.001;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("sd_scale", self.sd_scale, Unit{"m/m"}, Range{0.0, 1.0},
          "expected error of the scale: pitch and height of the camera are known only so well");
    field("sd_turn", self.sd_turn, Unit{"rad/m"}, Range{0.0, 1.0},
          "expected heading error per metre that every frame has");
    field("sd_shift", self.sd_shift, Unit{"m/rad"}, Range{0.0, 1.0},
          "how far the robot may be shifted, unnoticed by the wheels, when it turns on the spot");
  }
};

}  // namespace ipm_mapping
