#pragma once
// Registers of the FPGA model that somebody may turn (rule numbers: docs/fpga_contract.md).

#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

struct FpgaParameters {
  bool paper_order = false;
  bool undistort_current = true;
  bool use_horizon = true;
  int memory_rows = 819;
  int min_threshold = 6;
  bool mean_pixel_focus = false;
  ContactMethod method = ContactMethod::Triangle;
  int score_min = 4;
  int min_height = 5;
  bool single_bin_peaks = false;
  int valley_threshold = 1;
  FreeSpaceRule free_space_rule = FreeSpaceRule::DeepValley;
  int bearing_tolerance = 1;

  /// The source's own settings, with only its outright errors mended.
  [[nodiscard]] static FpgaParameters paper() {
    FpgaParameters p;
    p.min_threshold = 0;
    p.mean_pixel_focus = true;
    p.single_bin_peaks = true;
    return p;
  }

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("paper_order", self.paper_order,
          "distort before the homography, as the source does (§6.2.2): shows what that costs");
    field("undistort_current", self.undistort_current,
          "undistort the current stream too; off: it is subtracted raw, as in the source (§6.4)");
    field("use_horizon", self.use_horizon,
          "pixels above the horizon have no correspondence; off: they pass for floor, as in the "
          "source");
    field("memory_rows", self.memory_rows, Unit{"rows"}, Range{1, 524288},
          "rows of the ring memory that holds the reference frame (§6.4); limited per frame to "
          "what 19 address bits reach, and to the image height from below");
    field("min_threshold", self.min_threshold, Unit{"grey levels"}, Range{0, 255},
          "the mask is never made with a lower threshold");
    field("mean_pixel_focus", self.mean_pixel_focus,
          "eq. 6.9, the mean of the two vanishing points as pixels, while both lie in front");
    field("method", self.method, "score: eq. 5.6-5.8; triangle: eq. 5.9-5.16");
    field("score_min", self.score_min, Unit{""}, Range{0, 511},
          "the score has to be higher for a contact");
    field("min_height", self.min_height, Unit{"rows"}, Range{0, 511},
          "rows of decreasing width that make a triangle");
    field("single_bin_peaks", self.single_bin_peaks, "only runs of one bin are peaks (§6.9)");
    field("valley_threshold", self.valley_threshold, Unit{""}, Range{1, 31},
          "weight of the valley's area against the area under the histogram");
    field("free_space_rule", self.free_space_rule,
          "deep_valley: two obstacles where the valley between two peaks is deep (the source, "
          "§3.7); printed: the comparison printed in §6.9");
    field("bearing_tolerance", self.bearing_tolerance, Unit{"lines"}, Range{0, 79},
          "how far a contact may lie from the peak that it serves");
  }
};

/// Clock and blanking of the cycle model (docs/fpga.md).
struct FpgaClockParameters {
  double pixel_clock = 62.36e6;
  int line_blanking = 0;
  int frame_blanking = 0;
  double matrix_time = 129e-6;
  double point_time = 56e-6;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("pixel_clock", self.pixel_clock, Unit{"Hz"}, Range{1e5, 1e9},
          "clock of sensor and datapath, one pixel a cycle (the source's 203 fps imply 62.36 MHz)");
    field("line_blanking", self.line_blanking, Unit{"cycles"}, Range{0, 100000},
          "pause after every row");
    field("frame_blanking", self.frame_blanking, Unit{"cycles"}, Range{0, 100000000},
          "pause after the last row's own");
    field("matrix_time", self.matrix_time, Unit{"s"}, Range{0.0, 1.0},
          "software: motion and homography (table 6.1: 55 + 74 us)");
    field("point_time", self.point_time, Unit{"s"}, Range{0.0, 1.0},
          "software: one contact point into the map (§6.10.2)");
  }
};

}  // namespace ipm_mapping
