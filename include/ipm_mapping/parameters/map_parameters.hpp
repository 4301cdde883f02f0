#pragma once
// Parameters of the occupancy map and of the odometry's gate.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

enum class MapUpdate { LogOdds, MarkOnce };
template <>
inline constexpr std::array<const char*, 2> enum_names<MapUpdate>{"log_odds", "mark_once"};

/// What becomes of the map when a localiser puts the odometry's frame elsewhere.
enum class MapCorrection { Follow, Spread, Keep };
template <>
inline constexpr std::array<const char*, 3> enum_names<MapCorrection>{"follow", "spread", "keep"};

/// Occupancy map (the source, §5.4.2, §7.3).
struct MapParameters {
  MapUpdate update = MapUpdate::LogOdds;
  double resolution = 0.05;
  double hit = 0.85;
  double miss = 0.25;
  double clamp = 3.5;
  double occupied_above = 0.65;
  double free_below = 0.35;
  double margin = 0.5;
  int block = 64;
  int max_side = 4096;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("update", self.update,
          "log_odds: hits and cleared rays accumulate; mark_once: a cell once hit stays occupied");
    field("resolution", self.resolution, Unit{"m"}, Range{0.005, 1.0}, "side of a cell");
    field("hit", self.hit, Unit{"log odds"}, Range{0.0, 10.0}, "a contact adds this to its cell");
    field("miss", self.miss, Unit{"log odds"}, Range{0.0, 10.0},
          "a ray over free floor takes this from every cell it crosses");
    field("clamp", self.clamp, Unit{"log odds"}, Range{0.1, 20.0},
          "bound of a cell's log odds on either side: how fast the map can change its mind");
    field("occupied_above", self.occupied_above, Unit{"probability"}, Range{0.5, 1.0},
          "a cell is published as occupied from this probability on");
    field("free_below", self.free_below, Unit{"probability"}, Range{0.0, 0.5},
          "a cell is published as free up to this probability");
    field("margin", self.margin, Unit{"m"}, Range{0.0, 100.0},
          "the map reaches at least this far around the robot: planners look for it there");
    field("block", self.block, Unit{"cells"}, Range{8, 1024}, "the map grows in steps of this");
    field("max_side", self.max_side, Unit{"cells"}, Range{64, 32768},
          "the map grows no larger on either side; what falls outside is counted");
  }
};

/// What odometry has to look like to be believed.
struct OdometryParameters {
  double max_speed = 40.0;
  double max_turn_rate = 20.0;
  double max_jump = 0.15;
  double max_turn_jump = 0.3;
  double max_gap = 0.5;
  double buffer = 20.0;
  double wait = 1.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("max_speed", self.max_speed, Unit{"m/s"}, Range{0.01, 200.0},
          "a pose that would need a higher speed is dropped; when the next message agrees with it, "
          "odometry was reset and history starts anew");
    field("max_turn_rate", self.max_turn_rate, Unit{"rad/s"}, Range{0.01, 200.0},
          "the same for turning");
    field("max_jump", self.max_jump, Unit{"m"}, Range{0.001, 100.0},
          "the same for a pose this far from where the motion so far leads (per 0.1 s)");
    field("max_turn_jump", self.max_turn_jump, Unit{"rad"}, Range{0.001, 10.0},
          "the same for the heading");
    field("max_gap", self.max_gap, Unit{"s"}, Range{0.001, 10.0},
          "no pose is interpolated between messages farther apart");
    field("buffer", self.buffer, Unit{"s"}, Range{0.1, 600.0}, "how long poses are kept");
    field(
        "wait", self.wait, Unit{"s"}, Range{0.0, 60.0},
        "a frame is dropped when frames this much newer came and odometry, which does not reach it "
        "yet, stood still this long");
  }
};

}  // namespace ipm_mapping
