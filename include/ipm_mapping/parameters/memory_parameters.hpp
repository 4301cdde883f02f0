#pragma once
// Parameters of what is kept of earlier frames beside the map.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

/// How long contacts and free floor hold while the robot shows nothing new, and how often a contact
/// has to be seen to be believed.
struct MemoryParameters {
  double hold = 10.0;
  double hold_free = 2.0;
  double hold_distance = 0.5;
  bool filter = false;
  int confirm_frames = 2;
  int confirm_of = 4;
  double confirm_radius = 0.06;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field(
        "hold", self.hold, Unit{"s"}, Range{0.0, 3600.0},
        "contacts of the last frames are published this long after they were seen while the robot "
        "turns on the spot, or stands and misses them, with growing age; 0: not at all");
    field("hold_free", self.hold_free, Unit{"s"}, Range{0.0, 3600.0},
          "the same for free floor, which somebody may step on, and for what moves");
    field("hold_distance", self.hold_distance, Unit{"m"}, Range{0.0, 100.0},
          "nothing holds this far from where it was seen");
    field("filter", self.filter,
          "keep only contacts that were seen in several of the last used frames");
    field("confirm_frames", self.confirm_frames, Unit{"frames"}, Range{1, 16},
          "in how many of them, the present one included");
    field("confirm_of", self.confirm_of, Unit{"frames"}, Range{1, 16}, "how many frames these are");
    field("confirm_radius", self.confirm_radius, Unit{"m"}, Range{0.001, 1.0},
          "contacts of different frames no farther apart on the floor are the same");
  }
};

}  // namespace ipm_mapping
