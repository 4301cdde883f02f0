#pragma once
// Parameters of the source's chain: reference choice, warp, segmentation, localisation.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

enum class ContactMethod { Score, Triangle };
template <>
inline constexpr std::array<const char*, 2> enum_names<ContactMethod>{"score", "triangle"};

enum class FreeSpaceRule { DeepValley, Printed };
template <>
inline constexpr std::array<const char*, 2> enum_names<FreeSpaceRule>{"deep_valley", "printed"};

enum class Beam { FullView, Source };
template <>
inline constexpr std::array<const char*, 2> enum_names<Beam>{"full_view", "source"};

enum class Selection { EveryBearing, Peaks };
template <>
inline constexpr std::array<const char*, 2> enum_names<Selection>{"every_bearing", "peaks"};

/// Which earlier frame the current one is compared with.
struct ReferenceParameters {
  bool previous_frame = false;
  double min_baseline = 0.10;
  double max_rotation = 0.35;
  double max_age = 4.0;
  double min_motion = 0.002;
  int history = 128;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("previous_frame", self.previous_frame,
          "compare with the previous frame, as the source does, whatever the baseline");
    field("min_baseline", self.min_baseline, Unit{"m"}, Range{0.0, 10.0},
          "the newest frame at least this far back is the reference");
    field("max_rotation", self.max_rotation, Unit{"rad"}, Range{0.0, 3.2},
          "a reference that was turned further away is not used");
    field("max_age", self.max_age, Unit{"s"}, Range{0.0, 60.0},
          "a reference that is older is not used");
    field("min_motion", self.min_motion, Unit{"m"}, Range{0.0, 1.0},
          "a frame that moved less since the frame before it brings no new evidence");
    field("history", self.history, Unit{"frames"}, Range{2, 1024},
          "frames that are kept as possible references");
  }
};

/// Gaussian, Otsu, erosion (the source, §3.4).
struct SegmentationParameters {
  bool previous_threshold = false;
  int min_threshold = 6;
  double min_separability = 0.35;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("previous_threshold", self.previous_threshold,
          "binarise with the threshold of the previous difference image, as the hardware does");
    field("min_threshold", self.min_threshold, Unit{"grey levels"}, Range{0, 255},
          "Otsu's threshold is never taken lower");
    field("min_separability", self.min_separability, Unit{""}, Range{0.0, 1.0},
          "a frame whose between-class share of the variance is lower has no obstacle pixels");
  }
};

/// Polar histogram, contact points, free space, selection (the source, chapter 5).
struct LocalizationParameters {
  int n_lines = 80;
  Beam beam = Beam::FullView;
  bool mean_pixel_focus = false;
  ContactMethod method = ContactMethod::Triangle;
  int window_half_width = 5;
  int min_height = 5;
  int score_min = 4;
  double min_width = 4.0;
  int max_gap = 2;
  bool lowest_minimum = true;
  bool clipped_contacts = false;
  FreeSpaceRule free_space_rule = FreeSpaceRule::DeepValley;
  double valley_threshold = 1.0;
  bool single_bin_peaks = false;
  Selection selection = Selection::EveryBearing;
  int bearing_tolerance = 1;
  double max_range = 0.0;
  double min_floor_share = 0.5;
  int min_occupied_pixels = 5;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("n_lines", self.n_lines, Unit{"lines"}, Range{8, 512}, "lines of the beam");
    field("beam", self.beam,
          "full_view: exact lines that cover the whole image; source: starting columns 8i + 4 of "
          "a 640 pixel row (scaled to the width), Bresenham");
    field("mean_pixel_focus", self.mean_pixel_focus,
          "eq. 6.9, the mean of the two vanishing points as pixels, while both lie in front");
    field("method", self.method, "score: eq. 5.6-5.8; triangle: eq. 5.9-5.16");
    field("window_half_width", self.window_half_width, Unit{"px"}, Range{1, 31},
          "pixels on either side of the line that are summed in a row");
    field("min_height", self.min_height, Unit{"rows"}, Range{1, 511},
          "rows of decreasing width that make a triangle");
    field("score_min", self.score_min, Unit{""}, Range{0, 511},
          "the score has to be higher for a contact");
    field("min_width", self.min_width, Unit{"px"}, Range{0.0, 63.0},
          "a triangle's surface has to exceed this times its height");
    field("max_gap", self.max_gap, Unit{"px"}, Range{0, 64},
          "background pixels on the line that a triangle survives");
    field("lowest_minimum", self.lowest_minimum,
          "the contact is the lowest row of the smallest width; off: the last accepted row");
    field("clipped_contacts", self.clipped_contacts,
          "a triangle cut off by the border or by invalid pixels makes a contact, as in the "
          "source; off: the bearing is blocked up to there");
    field("free_space_rule", self.free_space_rule,
          "with selection peaks. deep_valley: two obstacles where the valley between two peaks is "
          "deep (the source, "
          "§3.7); printed: the comparison printed in §6.9");
    field("valley_threshold", self.valley_threshold, Unit{""}, Range{0.0, 31.0},
          "with selection peaks: weight of the valley's area against the area under the histogram");
    field("single_bin_peaks", self.single_bin_peaks,
          "with selection peaks: only runs of one line are peaks, as the hardware's comparison has "
          "it");
    field("selection", self.selection,
          "every_bearing: the nearest contact of every occupied bearing; peaks: one contact an "
          "obstacle (algorithm 3, mended)");
    field("bearing_tolerance", self.bearing_tolerance, Unit{"lines"}, Range{0, 79},
          "with selection peaks: how far a contact may lie from the peak that it serves");
    field("max_range", self.max_range, Unit{"m"}, Range{0.0, 100.0},
          "contacts farther from the robot are dropped; 0: 2 m, or three times the distance at "
          "which the floor comes into view where that is more");
    field("min_floor_share", self.min_floor_share, Unit{""}, Range{0.0, 1.0},
          "a bearing with a smaller share of valid floor rows within max_range is unknown");
    field("min_occupied_pixels", self.min_occupied_pixels, Unit{"px"}, Range{1, 512},
          "obstacle pixels in a row on a line from which the floor behind them is not called free");
  }
};

}  // namespace ipm_mapping
