#pragma once
// Parameters of the self-calibration: what is wrong with the camera's stated pose and with
// odometry, from the floor's own motion.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

enum class CalibrationMode { Off, Report, Apply };
template <>
inline constexpr std::array<const char*, 3> enum_names<CalibrationMode>{"off", "report", "apply"};

/// Self-calibration of the vertical sweep, and of check_camera.
struct CalibrationParameters {
  CalibrationMode mode = CalibrationMode::Report;
  double readout_time = 0.0;
  bool learn_readout = true;
  bool learn_time_offset = true;
  double lens_shading = 0.0;
  bool learn_shading = true;
  double sd_pitch = 0.035;
  double sd_roll = 0.01;
  double sd_yaw = 0.005;
  double sd_height = 0.005;
  double sd_height_wrong = 0.06;
  double sd_scale = 0.02;
  double sd_turn_scale = 0.02;
  double sd_yaw_rate = 0.01;
  double sd_readout = 0.02;
  double sd_time_offset = 0.06;
  double sd_shading = 0.15;
  double sd_shading_pair = 0.03;
  double sd_sway = 0.001;
  double sd_forward = 0.02;
  double sd_sideways = 0.003;
  double sd_turn = 0.003;
  double max_tilt = 0.07;
  double max_height = 0.12;
  double max_time_offset = 0.25;
  double max_shading = 0.4;
  double spacing = 0.333;
  double settled_spacing = 1.5;
  double readout_turn = 0.15;
  double readout_known = 0.003;
  double time_offset_known = 0.005;
  double short_baseline = 0.15;
  double long_baseline = 0.667;
  double farthest = 4.5;
  int row_step = 10;
  int line_step = 15;
  int iterations = 32;
  int min_samples = 120;
  double min_likeness = 0.7;
  double correlation = 0.1;
  double memory = 200.0;
  double shading_memory = 60.0;
  int least_pairs = 4;
  double confident_tilt = 0.002;
  double confident_height = 0.015;
  double early_sigmas = 3.0;
  double apply_tilt = 0.001;
  double apply_height = 0.002;
  double apply_readout = 0.002;
  double readout_sigmas = 3.0;
  double apply_time_offset = 0.005;
  double time_offset_sigmas = 2.0;
  int time_offset_pairs = 2;
  double apply_shading = 0.01;
  double shading_sigmas = 3.0;
  int shading_pairs = 8;
  double warn_tilt = 0.0052;
  double warn_height = 0.01;
  double warn_time_offset = 0.02;
  double warn_sigmas = 3.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field(
        "mode", self.mode,
        "off; report: estimates on /diagnostics beside the stated pose; apply: the detector works "
        "with the estimated pose and odometry. Readout time and stamps are put right with both");
    field("readout_time", self.readout_time, Unit{"s"}, Range{-0.1, 0.1},
          "how long the camera takes to read an image, first row to last, as far as it is known: a "
          "rolling shutter shears what is seen while the robot turns; 0: all rows at once; "
          "negative: the image was turned upside down");
    field("learn_readout", self.learn_readout,
          "find out how long it takes, unless mode is off, and work with that; false: with "
          "readout_time as it is stated");
    field("learn_time_offset", self.learn_time_offset,
          "find out by how much the images' stamps are off odometry's clock, over "
          "camera/image_time_offset, unless mode is off, and work with that");
    field(
        "lens_shading", self.lens_shading, Unit{""}, Range{-0.4, 0.4},
        "by which share grey levels are darker in the corners of the image than in its centre, as "
        "far as it is known");
    field("learn_shading", self.learn_shading,
          "find out by how much, unless mode is off, and work with that; false: with lens_shading "
          "as it is stated");
    expectations(self, field);
    pairs(self, field);
    verdicts(self, field);
  }

 private:
  /// How far off things are expected to be, and may be.
  template <class Self, class Visitor>
  static void expectations(Self& self, Visitor& field) {
    field("sd_pitch", self.sd_pitch, Unit{"rad"}, Range{1e-6, 0.5},
          "how far off the stated pitch is expected to be");
    field("sd_roll", self.sd_roll, Unit{"rad"}, Range{1e-6, 0.5}, "the same of the roll");
    field("sd_yaw", self.sd_yaw, Unit{"rad"}, Range{1e-6, 0.5},
          "the same of the camera's heading on the robot");
    field("sd_height", self.sd_height, Unit{"m"}, Range{1e-6, 1.0},
          "how well the stated height was measured, unless it is wrong");
    field("sd_height_wrong", self.sd_height_wrong, Unit{"m"}, Range{1e-6, 1.0},
          "how far off it is expected to be if it is wrong");
    field(
        "sd_scale", self.sd_scale, Unit{""}, Range{1e-6, 0.5},
        "how far off odometry's scale may be: the floor shows height over way only, and the stated "
        "height is held to be wrong when this does not make up for what is off");
    field("sd_turn_scale", self.sd_turn_scale, Unit{"rad/rad"}, Range{1e-6, 0.5},
          "odometry's heading error expected per radian turned");
    field("sd_yaw_rate", self.sd_yaw_rate, Unit{"rad/s"}, Range{1e-6, 0.5},
          "odometry's heading error expected per second");
    field("sd_readout", self.sd_readout, Unit{"s"}, Range{1e-6, 0.1},
          "how far off the stated readout_time is expected to be");
    field("sd_time_offset", self.sd_time_offset, Unit{"s"}, Range{1e-6, 1.0},
          "how far off odometry's clock the images' stamps are expected to be");
    field("sd_shading", self.sd_shading, Unit{""}, Range{1e-6, 1.0},
          "how far off the stated lens_shading is expected to be");
    field("sd_shading_pair", self.sd_shading_pair, Unit{""}, Range{0.0, 1.0},
          "what one pair of frames says of it is taken to be off by as much");
    field("sd_sway", self.sd_sway, Unit{"rad"}, Range{1e-6, 0.1},
          "how much pitch and roll of the robot differ from frame to frame");
    field("sd_forward", self.sd_forward, Unit{"m/m"}, Range{1e-6, 1.0},
          "odometry's error along x per metre that differs from pair to pair");
    field("sd_sideways", self.sd_sideways, Unit{"m/m"}, Range{1e-6, 1.0}, "the same along y");
    field("sd_turn", self.sd_turn, Unit{"rad/m"}, Range{1e-6, 1.0}, "the same of the heading");
    field("max_tilt", self.max_tilt, Unit{"rad"}, Range{0.0, 0.2},
          "an estimate farther from the stated pitch, roll or yaw is not believed");
    field("max_height", self.max_height, Unit{"m"}, Range{0.0, 1.0},
          "an estimate farther from the stated height is not believed");
    field("max_time_offset", self.max_time_offset, Unit{"s"}, Range{0.0, 1.0},
          "stamps are not moved by more");
    field("max_shading", self.max_shading, Unit{""}, Range{0.0, 0.8},
          "images are not brightened in the corners by more than what this makes up for");
  }
  /// Which frames are compared, and how.
  template <class Self, class Visitor>
  static void pairs(Self& self, Visitor& field) {
    field("spacing", self.spacing, Unit{"camera heights"}, Range{0.01, 10.0},
          "way from one compared pair of frames to the next");
    field("settled_spacing", self.settled_spacing, Unit{"camera heights"}, Range{0.01, 100.0},
          "the same once the estimate is confident and the height no longer in doubt");
    field("readout_turn", self.readout_turn, Unit{"rad/s"}, Range{0.0, 10.0},
          "pairs follow one another after short_baseline while the robot turns faster and the "
          "readout time is not known well, or where the turn has changed by more and what the "
          "stamps are off is not");
    field("readout_known", self.readout_known, Unit{"s"}, Range{0.0, 0.1},
          "how well is enough, one sigma");
    field("time_offset_known", self.time_offset_known, Unit{"s"}, Range{0.0, 1.0},
          "the same of the images' stamps");
    field("short_baseline", self.short_baseline, Unit{"camera heights"}, Range{0.01, 10.0},
          "way between the two frames of a pair while little is known");
    field("long_baseline", self.long_baseline, Unit{"camera heights"}, Range{0.01, 10.0},
          "the same once the estimate is good enough for the views to overlap");
    field("farthest", self.farthest, Unit{"camera heights"}, Range{1.0, 50.0},
          "floor farther from the camera's foot does not take part");
    field("row_step", self.row_step, Unit{"rows"}, Range{1, 64}, "every how many rows a sample");
    field("line_step", self.line_step, Unit{"lines"}, Range{1, 64}, "every how many lines");
    field("iterations", self.iterations, Unit{""}, Range{1, 50}, "at most so many steps a pair");
    field("min_samples", self.min_samples, Unit{""}, Range{10, 100000},
          "a pair with fewer samples that fit is not used");
    field("min_likeness", self.min_likeness, Unit{""}, Range{0.0, 1.0},
          "a pair whose aligned floor correlates less is not used: too little texture, or aligned "
          "wrongly");
    field("correlation", self.correlation, Unit{""}, Range{1e-4, 1.0},
          "share of independent samples");
    field("memory", self.memory, Unit{"pairs"}, Range{2.0, 1e6},
          "older pairs fade: their weight falls to 1/e over this many");
    field("shading_memory", self.shading_memory, Unit{"pairs"}, Range{2.0, 1e6},
          "the same of what pairs say of the lens: every used frame makes one or two");
  }
  /// When the estimate is believed, applied and warned of.
  template <class Self, class Visitor>
  static void verdicts(Self& self, Visitor& field) {
    field("least_pairs", self.least_pairs, Unit{"pairs"}, Range{1, 1000},
          "nothing is believed before so many");
    field("confident_tilt", self.confident_tilt, Unit{"rad"}, Range{0.0, 0.1},
          "an estimate is applied when the pitch is known this well (one sigma)");
    field("confident_height", self.confident_height, Unit{""}, Range{0.0, 0.5},
          "the same of height over distance driven");
    field("early_sigmas", self.early_sigmas, Unit{"sigma"}, Range{0.0, 100.0},
          "or, less well known, when it is this far from what is in force");
    field("apply_tilt", self.apply_tilt, Unit{"rad"}, Range{0.0, 0.1},
          "in either case it has to differ this much from the pitch or roll in force");
    field("apply_height", self.apply_height, Unit{"m"}, Range{0.0, 0.5},
          "or this much from the height in force");
    field("apply_readout", self.apply_readout, Unit{"s"}, Range{0.0, 0.1},
          "another readout time comes into force where it differs by more");
    field("readout_sigmas", self.readout_sigmas, Unit{"sigma"}, Range{0.0, 100.0},
          "and by so much");
    field("apply_time_offset", self.apply_time_offset, Unit{"s"}, Range{0.0, 1.0},
          "stamps are moved anew where what they are off differs by more from what they are moved "
          "by");
    field("time_offset_sigmas", self.time_offset_sigmas, Unit{"sigma"}, Range{0.0, 100.0},
          "and by so much");
    field("time_offset_pairs", self.time_offset_pairs, Unit{"pairs"}, Range{1, 1000},
          "and after so many: one alone may be aligned wrongly");
    field("apply_shading", self.apply_shading, Unit{""}, Range{0.0, 1.0},
          "another lens shading comes into force where it differs by more");
    field("shading_sigmas", self.shading_sigmas, Unit{"sigma"}, Range{0.0, 100.0},
          "and by so much");
    field("shading_pairs", self.shading_pairs, Unit{"pairs"}, Range{1, 1000}, "and after so many");
    field("warn_tilt", self.warn_tilt, Unit{"rad"}, Range{0.0, 0.5},
          "diagnostics warn when the stated pitch or roll is off by more, and by warn_sigmas");
    field("warn_height", self.warn_height, Unit{"m"}, Range{0.0, 1.0}, "the same of the height");
    field("warn_time_offset", self.warn_time_offset, Unit{"s"}, Range{0.0, 1.0},
          "check_camera asks for another camera/image_time_offset where it is off by more");
    field("warn_sigmas", self.warn_sigmas, Unit{"sigma"}, Range{0.0, 100.0},
          "how sure such a warning is");
  }
};

}  // namespace ipm_mapping
