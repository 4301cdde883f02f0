#pragma once
// Parameters of the vertical sweep. Lengths that depend on how high the camera stands are in camera
// heights; costs are in squared standard deviations of the grey-level noise.

#include "ipm_mapping/parameters/field.hpp"
#include "ipm_mapping/parameters/foot_parameters.hpp"
#include "ipm_mapping/parameters/free_floor_parameters.hpp"
#include "ipm_mapping/parameters/motion_refinement_parameters.hpp"

namespace ipm_mapping::sweep {

/// The polar grid that images are rectified to.
struct GridParameters {
  double lines_per_radian = 400.0;
  double rows_per_log = 200.0;
  double max_range = 0.0;
  double beyond = 1.6;
  double max_support = 0.667;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("lines_per_radian", self.lines_per_radian, Unit{"1/rad"}, Range{50.0, 2000.0},
          "lines of equal azimuth per radian");
    field("rows_per_log", self.rows_per_log, Unit{"1"}, Range{50.0, 1000.0},
          "rows per unit of the logarithm of the distance");
    field("max_range", self.max_range, Unit{"m"}, Range{0.0, 1000.0},
          "contacts farther from the robot are not published; 0: 2 m, or three times the distance "
          "at which the floor comes into view where that is more");
    field("beyond", self.beyond, Unit{""}, Range{1.0, 10.0},
          "candidates reach this multiple of max_range, so that what stands behind it is not drawn "
          "into it");
    field("max_support", self.max_support, Unit{"camera heights"}, Range{0.05, 0.95},
          "how far up a vertical line is followed");
  }
};

/// Which earlier frames the current one is compared with.
struct SweepReferenceParameters {
  double short_baseline = 0.333;
  double long_baseline = 0.667;
  double least_long_baseline = 0.2;
  double max_rotation = 0.35;
  double max_age = 4.0;
  double watch = 300.0;
  double min_motion = 0.002;
  double spacing = 0.02;
  int history = 96;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("short_baseline", self.short_baseline, Unit{"camera heights"}, Range{0.01, 10.0},
          "the newest frame at least this far back is the first reference");
    field("long_baseline", self.long_baseline, Unit{"camera heights"}, Range{0.0, 10.0},
          "the same for the second reference; 0: only one reference");
    field("least_long_baseline", self.least_long_baseline, Unit{"m"}, Range{0.0, 10.0},
          "the second reference is at least this far back however low the camera: how far away a "
          "thing shows that it stands upright depends on this");
    field("max_rotation", self.max_rotation, Unit{"rad"}, Range{0.0, 3.2},
          "a reference that was turned further away is not used");
    field("max_age", self.max_age, Unit{"s"}, Range{0.0, 60.0},
          "a reference that is older is not used");
    field("watch", self.watch, Unit{"s"}, Range{0.0, 86400.0},
          "a robot that stands goes on looking for so long, with the references from before: what "
          "comes is seen, and that it has left; 0: it gives no answer of its own");
    field("min_motion", self.min_motion, Unit{"m"}, Range{0.0, 1.0},
          "a frame that moved less since the frame before it brings no new evidence");
    field("spacing", self.spacing, Unit{"camera heights"}, Range{0.0, 1.0},
          "a frame is kept as a possible reference when it is this far from the one kept before");
    field("history", self.history, Unit{"frames"}, Range{2, 1024},
          "frames that are kept as possible references");
  }
};

/// What a grey-level difference may be without meaning anything.
struct NoiseParameters {
  double sigma = 1.06;
  double dark_share = 0.3;
  double bright_unit = 128.0;
  double azimuth_error = 0.0014;
  double slope_error = 0.00097;
  double slope_step = 0.0028;
  double blur_azimuth = 0.00283;
  double blur_slope = 0.00196;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("sigma", self.sigma, Unit{"grey levels"}, Range{0.05, 50.0},
          "sensor noise of a difference of two images at bright_unit");
    field("dark_share", self.dark_share, Unit{""}, Range{0.0, 10.0},
          "share of the noise variance that is there in the dark");
    field("bright_unit", self.bright_unit, Unit{"grey levels"}, Range{1.0, 255.0},
          "brightness that adds a whole variance of sigma (shot noise)");
    field("azimuth_error", self.azimuth_error, Unit{"rad"}, Range{0.0, 0.1},
          "misregistration sideways that has to be expected");
    field("slope_error", self.slope_error, Unit{""}, Range{0.0, 0.1},
          "misregistration along a line, in units of r = height / distance");
    field("slope_step", self.slope_step, Unit{""}, Range{0.0001, 0.1},
          "half-width, in units of r, over which the derivative along a line is taken");
    field("blur_azimuth", self.blur_azimuth, Unit{"rad"}, Range{0.0, 0.1},
          "width sideways by which one view may be blurred more than the other");
    field("blur_slope", self.blur_slope, Unit{""}, Range{0.0, 0.1},
          "the same along a line, in units of r");
  }
};

/// Costs of the floor and of a vertical line, and their difference.
struct EvidenceParameters {
  double floor_cap = 2.5;
  double vertical_prior = 0.02;
  double vertical_brightness = 0.5;
  double brightness_support = 0.4;
  double least_vertical_cost = 0.1;
  double rival_share = 0.6;
  double specular_prior = 0.2;
  double specular_parallax = 0.12;
  double drift_width = 0.085;
  double drift_length = 0.10;
  double evidence_rows = 360.0;
  int beam_step = 6;
  int search_step = 2;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("floor_cap", self.floor_cap, Unit{"sigma^2"}, Range{0.1, 9.0},
          "the floor never costs more: 'neither floor nor vertical' is an allowed answer");
    field("vertical_prior", self.vertical_prior, Unit{"sigma^2"}, Range{0.0, 2.0},
          "a vertical line costs this much more a row");
    field("vertical_brightness", self.vertical_brightness, Unit{"grey levels"}, Range{0.0, 32.0},
          "an upright surface may become brighter or darker by so much between the views: light "
          "falls on it from elsewhere, lenses darken towards their corners; mirror images change "
          "more; 0: not at all");
    field("brightness_support", self.brightness_support, Unit{"camera heights"}, Range{0.01, 0.95},
          "how far up the surface shows by how much");
    field("least_vertical_cost", self.least_vertical_cost, Unit{"sigma^2"}, Range{0.0, 1.0},
          "no vertical line is expected to fit better a row: what could not score otherwise is not "
          "tried; 0: nothing is left out");
    field("rival_share", self.rival_share, Unit{""}, Range{0.0, 1.0},
          "a candidate that cannot reach this share of the best score nearer in its beam is not "
          "tried; 0: nothing is left out");
    field(
        "specular_prior", self.specular_prior, Unit{"sigma^2"}, Range{0.0, 9.0},
        "a highlight that stays where it is in the view costs this much more a row than floor; 9: "
        "not considered");
    field("specular_parallax", self.specular_parallax, Unit{"log"}, Range{0.0, 2.0},
          "considered only where the floor moves at least this much between the views: far things "
          "hardly move either");
    field(
        "drift_width", self.drift_width, Unit{"rad"}, Range{0.01, 1.0},
        "width of the neighbourhood whose mean difference a drifting highlight or shadow explains");
    field("drift_length", self.drift_length, Unit{"log"}, Range{0.01, 1.0},
          "its length, in the logarithm of the distance");
    field("evidence_rows", self.evidence_rows, Unit{"1"}, Range{1.0, 10000.0},
          "independent observations per unit of r: scores count these");
    field("beam_step", self.beam_step, Unit{"lines"}, Range{1, 64}, "lines from beam to beam");
    field("search_step", self.search_step, Unit{"candidates"}, Range{1, 8},
          "every how many candidates one is evaluated before the maxima are");
  }
};

/// From scores to one contact a beam.
struct SelectionParameters {
  double nearer_score = 15.0;
  double publish_score = 4.0;
  double publish_slope = 20.0;
  double weak_share = 0.3;
  double top_length = 0.08;
  int top_reach = 4;
  double step_cost = 0.5;
  double jump_cost = 20.0;
  double nothing_cost = 12.0;
  double presence_cost = 2.0;
  double score_cap = 60.0;
  int refine_steps = 4;
  int lean_reach = 14;
  double lean_gain = 1.02;
  double lean_doubt = 0.8;
  double edge_score = 20.0;
  double edge_contrast = 12.0;
  int edge_farther = 4;
  int edge_nearer = 6;
  bool straddle = true;
  double straddle_gap = 0.133;
  double straddle_ratio = 1.5;
  int lone_frames = 2;
  int lone_of = 4;
  double least_height = 0.0225;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("nearer_score", self.nearer_score, Unit{""}, Range{0.0, 1000.0},
          "a nearer candidate with this score hides what stands behind it");
    field("publish_score", self.publish_score, Unit{""}, Range{0.0, 1000.0},
          "a beam's own score for a contact to be published");
    field("publish_slope", self.publish_slope, Unit{""}, Range{0.0, 1000.0},
          "the same per unit of r, where that is more: near the camera a centimetre is many rows");
    field("weak_share", self.weak_share, Unit{""}, Range{0.1, 1.0},
          "a candidate with this share of what it takes to be published is doubtful: its level top "
          "counts as well, and the floor behind it is not called free");
    field("top_length", self.top_length, Unit{"log"}, Range{0.0, 1.0},
          "a level top that is seen over less, in the logarithm of the distance, says nothing; 0: "
          "tops are not looked for");
    field("top_reach", self.top_reach, Unit{"candidates"}, Range{0, 32},
          "how far below the upper end of a face its top may begin: the face seems to go on there");
    field("step_cost", self.step_cost, Unit{""}, Range{0.0, 100.0},
          "cost of one candidate step between neighbouring beams");
    field("jump_cost", self.jump_cost, Unit{""}, Range{0.0, 1000.0},
          "the most that a step between neighbouring beams costs");
    field("nothing_cost", self.nothing_cost, Unit{""}, Range{0.0, 1000.0},
          "cost of going to or from 'nothing here'");
    field("presence_cost", self.presence_cost, Unit{""}, Range{0.0, 100.0},
          "cost of a contact in a beam: less evidence is nothing");
    field("score_cap", self.score_cap, Unit{""}, Range{1.0, 10000.0},
          "scores of a beam are scaled (not clipped) to at most this");
    field("refine_steps", self.refine_steps, Unit{"candidates"}, Range{0, 64},
          "how far from the smooth solution a beam's own maximum may lie");
    field("lean_reach", self.lean_reach, Unit{"candidates"}, Range{0, 128},
          "how far in front of a contact the foot of a surface that leans away is looked for; 0: "
          "everything stands upright");
    field("lean_gain", self.lean_gain, Unit{""}, Range{1.0, 10.0},
          "such a surface has to score this many times the upright one");
    field("lean_doubt", self.lean_doubt, Unit{""}, Range{0.0, 1.0},
          "an upright surface that explains this share of what does not look like floor is not "
          "doubted");
    field("edge_score", self.edge_score, Unit{""}, Range{0.0, 1000.0},
          "what the image's edge at an obstacle's foot adds to a candidate at most; 0: not used");
    field("edge_contrast", self.edge_contrast, Unit{"grey levels/row"}, Range{0.1, 255.0},
          "change of the grey level along the line at which an edge adds half of that");
    field("edge_farther", self.edge_farther, Unit{"candidates"}, Range{0, 64},
          "how far behind the score's maximum the edge may lie");
    field("edge_nearer", self.edge_nearer, Unit{"candidates"}, Range{0, 64},
          "how far in front of it: surfaces that lean away are seen too far");
    field("straddle", self.straddle,
          "drop a contact beside a clearly nearer and stronger one, or between two clearly nearer "
          "ones: "
          "its beam straddles an edge");
    field("straddle_gap", self.straddle_gap, Unit{"camera heights"}, Range{0.0, 10.0},
          "how much nearer 'clearly nearer' is");
    field("straddle_ratio", self.straddle_ratio, Unit{""}, Range{1.0, 100.0},
          "how much stronger 'clearly stronger' is");
    field(
        "lone_frames", self.lone_frames, Unit{"frames"}, Range{1, 16},
        "a contact that no other one stands beside counts when it was seen in so many of the last "
        "lone_of used frames, its own included; 1: at once");
    field("lone_of", self.lone_of, Unit{"frames"}, Range{1, 16},
          "how many frames these are; more than these are never asked for");
    field("least_height", self.least_height, Unit{"m"}, Range{0.0, 1.0},
          "what is seen to be lower is no obstacle: a cable, the edge of a rug; it looks half a "
          "centimetre to a centimetre higher than it is");
  }
};

/// What has come onto floor that was free a moment ago.
struct MovingParameters {
  double moving_score = 20.0;
  double moving_cost = 3.0;
  double moving_height = 0.2;
  double moving_width = 0.05;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("moving_score", self.moving_score, Unit{""}, Range{0.0, 1000.0},
          "what stands on floor that was free a moment ago, and does not look like floor by so "
          "much, is a contact: somebody has come; 0: what moves is not looked for");
    field("moving_cost", self.moving_cost, Unit{"sigma^2"}, Range{0.1, 9.0},
          "a row that costs the floor less says that it is floor");
    field("moving_height", self.moving_height, Unit{"camera heights"}, Range{0.0, 0.9},
          "it has to be at least so high, and least_height");
    field("moving_width", self.moving_width, Unit{"m"}, Range{0.0, 10.0}, "and so wide");
  }
};

/// How well the camera's pose is known: what a contact's range is worth.
struct CalibrationUncertainty {
  double sd_pitch = 0.0035;
  double sd_height = 0.004;
  double least_sharpness = 0.25;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("sd_pitch", self.sd_pitch, Unit{"rad"}, Range{0.0, 0.5}, "expected error of the pitch");
    field("sd_height", self.sd_height, Unit{"m"}, Range{0.0, 1.0}, "expected error of the height");
    field("least_sharpness", self.least_sharpness, Unit{"1/candidate^2"}, Range{1e-6, 100.0},
          "a flatter maximum of the score counts as this sharp");
  }
};

/// Everything the vertical sweep can be told.
struct SweepParameters {
  GridParameters grid;
  SweepReferenceParameters reference;
  MotionRefinementParameters refinement;
  NoiseParameters noise;
  EvidenceParameters evidence;
  SelectionParameters selection;
  FreeFloorParameters free_floor;
  FootParameters foot;
  MovingParameters moving;
  CalibrationUncertainty uncertainty;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    GridParameters::fields(self.grid, field);
    SweepReferenceParameters::fields(self.reference, field);
    MotionRefinementParameters::fields(self.refinement, field);
    NoiseParameters::fields(self.noise, field);
    EvidenceParameters::fields(self.evidence, field);
    SelectionParameters::fields(self.selection, field);
    FreeFloorParameters::fields(self.free_floor, field);
    FootParameters::fields(self.foot, field);
    MovingParameters::fields(self.moving, field);
    CalibrationUncertainty::fields(self.uncertainty, field);
  }
};

}  // namespace ipm_mapping::sweep
