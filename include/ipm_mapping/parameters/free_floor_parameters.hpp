#pragma once

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping::sweep {

/// What of the floor that looks like floor may be called free.
struct FreeFloorParameters {
  double free_cost = 2.0;
  double free_edge = 6.0;
  int free_halo = 6;
  double free_gap = 0.3;
  double near_memory = 30.0;
  double blocked_cost = 2.0;
  int free_window = 15;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("free_cost", self.free_cost, Unit{"sigma^2"}, Range{0.0, 9.0},
          "floor is called free while its mean cost stays below this");
    field(
        "free_edge", self.free_edge, Unit{"grey levels/row"}, Range{0.1, 255.0},
        "behind an edge of the image with this contrast only floor whose texture is seen to go on "
        "there is called free: something plain may stand there; 255: not asked");
    field("free_halo", self.free_halo, Unit{"beams"}, Range{0, 100},
          "floor is called free no farther than the contacts this many beams beside it: an "
          "obstacle's "
          "plain parts look like floor");
    field("free_gap", self.free_gap, Unit{"m"}, Range{0.0, 10.0},
          "between two contacts closer together than this nothing behind them is free: no robot "
          "passes there");
    field("near_memory", self.near_memory, Unit{"s"}, Range{0.0, 3600.0},
          "how long a contact that passed below the view goes on hiding what is behind it; 0: not");
    field("blocked_cost", self.blocked_cost, Unit{"sigma^2"}, Range{0.0, 9.0},
          "a beam without contact whose nearest floor costs more than this is blocked: something "
          "stands nearer than the view");
    field("free_window", self.free_window, Unit{"rows"}, Range{1, 100},
          "over how many rows that mean is taken");
  }
};

}  // namespace ipm_mapping::sweep
