#pragma once
// Parameters of the motion refinement: how the floor's own motion corrects odometry's.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping::sweep {

/// Refinement of the odometry's motion on the floor, and of the brightness between two frames.
struct MotionRefinementParameters {
  bool refine = true;
  double farthest = 5.5;
  int row_step = 6;
  int line_step = 16;
  int iterations = 20;
  double first_spread = 16.0;
  double sd_forward = 0.04;
  double sd_sideways = 0.003;
  double sd_turn = 0.003;
  double sd_turn_share = 0.02;
  double sd_turn_rate = 0.01;
  double sd_forward_floor = 0.001;
  double sd_sideways_floor = 0.0003;
  double sd_turn_floor = 0.0005;
  double sd_sway = 0.0003;
  double least_sway = 0.0003;
  double sd_gain = 0.1;
  double sd_offset = 2.0;
  double correlation = 0.1;
  int min_samples = 100;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("refine", self.refine, "align the floor of the two frames; off: trust odometry");
    field("farthest", self.farthest, Unit{"camera heights"}, Range{1.0, 50.0},
          "floor farther from the camera's foot does not take part");
    field("row_step", self.row_step, Unit{"rows"}, Range{1, 64}, "every how many rows a sample");
    field("line_step", self.line_step, Unit{"lines"}, Range{1, 64}, "every how many lines");
    field("iterations", self.iterations, Unit{""}, Range{1, 50}, "at most so many steps");
    field("first_spread", self.first_spread, Unit{"grey levels"}, Range{1.0, 255.0},
          "spread that the first step allows for, halved at every step: edges that do not overlap "
          "yet");
    field("sd_forward", self.sd_forward, Unit{"m/m"}, Range{1e-6, 1.0},
          "expected odometry error along x per metre");
    field("sd_sideways", self.sd_sideways, Unit{"m/m"}, Range{1e-6, 1.0}, "the same along y");
    field("sd_turn", self.sd_turn, Unit{"rad/m"}, Range{1e-6, 1.0}, "heading error per metre");
    field("sd_turn_share", self.sd_turn_share, Unit{"rad/rad"}, Range{0.0, 1.0},
          "heading error per radian turned");
    field("sd_turn_rate", self.sd_turn_rate, Unit{"rad/s"}, Range{0.0, 1.0},
          "heading error per second: bias of a gyroscope or of unequal wheels");
    field("sd_forward_floor", self.sd_forward_floor, Unit{"m"}, Range{1e-6, 1.0},
          "error along x that is there without motion");
    field("sd_sideways_floor", self.sd_sideways_floor, Unit{"m"}, Range{1e-6, 1.0},
          "the same along y");
    field("sd_turn_floor", self.sd_turn_floor, Unit{"rad"}, Range{1e-6, 1.0},
          "the same of the heading");
    field("sd_sway", self.sd_sway, Unit{"rad"}, Range{1e-6, 0.1},
          "how much pitch and roll of the robot usually differ between two frames; nods have heavy "
          "tails");
    field("least_sway", self.least_sway, Unit{"rad"}, Range{0.0, 0.1},
          "a smaller sway is left in the images");
    field("sd_gain", self.sd_gain, Unit{""}, Range{1e-4, 10.0}, "expected change of the gain");
    field("sd_offset", self.sd_offset, Unit{"grey levels"}, Range{1e-3, 100.0},
          "expected change of the offset");
    field("correlation", self.correlation, Unit{""}, Range{1e-4, 1.0},
          "share of independent samples: neighbours see the same texture and the same model error");
    field("min_samples", self.min_samples, Unit{""}, Range{10, 100000},
          "with fewer floor samples odometry stays as it is");
  }
};

}  // namespace ipm_mapping::sweep
