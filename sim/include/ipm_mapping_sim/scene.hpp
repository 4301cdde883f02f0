#pragma once
// A scene is data: what stands where, what lights it, how the robot drives and how well it senses.
//
// Each struct lists its fields once; reading YAML, range checks and the scene's copy in the truth
// file are visitors of that list. World = the robot's first pose (x forward, y left, z up, floor at
// z = 0). Lengths in metres, angles in radians, reflectances and radiances linear in 0...1.

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping::sim {

using Point = Eigen::Vector2d;

enum class Grain { None, Speckle, Clouds, Wood, Fibre, Concrete, Marble };
enum class Pattern { None, Bands, Carton, Books };
enum class ObstacleKind { Box, Cylinder, Cone, Legs, Heap, Cable, Pallet, Shelf };
enum class PaintKind { Line, Patch, Disc };

/// Surface of anything that is not the floor.
struct Material {
  double albedo = 0.4;
  Grain grain = Grain::Speckle;
  double grain_contrast = 0.15;
  double grain_size = 0.5;
  Pattern pattern = Pattern::None;
  double pattern_albedo = 0.8;
  double pattern_period = 0.2;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("albedo", self.albedo, Unit{}, Range{0.0, 1.0}, "mean share of light sent back");
    field("grain", self.grain, "kind of texture");
    field("grain_contrast", self.grain_contrast, Unit{}, Range{0.0, 1.0}, "relative amplitude");
    field("grain_size", self.grain_size, Unit{"m"}, Range{0.01, 10.0}, "repeat of the texture");
    field("pattern", self.pattern, "regular markings over the texture");
    field("pattern_albedo", self.pattern_albedo, Unit{}, Range{0.0, 1.0}, "their reflectance");
    field("pattern_period", self.pattern_period, Unit{"m"}, Range{0.01, 10.0}, "their spacing");
  }
};

/// A place on a moving thing's way: it goes straight from one to the next, and stays where it is
/// before the first and after the last.
struct Waypoint {
  double at = 0.0, x = 0.0, y = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-100.0, 100.0};
    field("at", self.at, Unit{"s"}, Range{-1e5, 1e5}, "when it is there, after the first frame");
    field("x", self.x, Unit{"m"}, place, "how far it has gone from its x");
    field("y", self.y, Unit{"m"}, place, "how far it has gone from its y");
  }
};

/// How far a thing has gone along its way.
Point goneAlong(const std::vector<Waypoint>& way, double time);

/// Anything standing or lying on the floor; which lengths count depends on the kind.
struct ObstacleSpec {
  ObstacleKind kind = ObstacleKind::Box;
  std::string name;
  double x = 0.0, y = 0.0, z = 0.0, yaw = 0.0;
  double lx = 0.3, ly = 0.3, h = 0.3, r = 0.1, leg = 0.04, back = 0.0;
  std::vector<Point> points;
  std::vector<Waypoint> way;
  Material material;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-100.0, 100.0}, length{0.001, 50.0}, any{0.0, 50.0};
    field("kind", self.kind, "box, cylinder, cone, legs, heap, cable, pallet or shelf");
    field("name", self.name, "label in the truth file");
    field("x", self.x, Unit{"m"}, place, "centre, forward");
    field("y", self.y, Unit{"m"}, place, "centre, left");
    field("z", self.z, Unit{"m"}, any, "height of the underside; 0 stands on the floor");
    field("yaw", self.yaw, Unit{"rad"}, Range{-7.0, 7.0}, "turn about the vertical");
    field("lx", self.lx, Unit{"m"}, length, "length along its own x");
    field("ly", self.ly, Unit{"m"}, length, "length along its own y");
    field("h", self.h, Unit{"m"}, length, "height");
    field("r", self.r, Unit{"m"}, length, "radius");
    field("leg", self.leg, Unit{"m"}, length, "side of a leg's square section");
    field("back", self.back, Unit{"m"}, any, "height of a chair's back above the seat");
    field("points", self.points, "course of a cable");
    field("way", self.way, "where it goes; none: it stands still");
    field("material", self.material, "surface");
  }
};

struct WallSpec {
  Point from = Point::Zero(), to = Point::UnitX();
  double height = 2.6, thickness = 0.12, skirting = 0.07;
  double skirting_albedo = 0.12;
  Material material{0.6, Grain::Clouds, 0.05, 2.0, Pattern::None, 0.8, 0.2};

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("from", self.from, "one end of the centre line");
    field("to", self.to, "the other end");
    field("height", self.height, Unit{"m"}, Range{0.01, 10.0}, "height");
    field("thickness", self.thickness, Unit{"m"}, Range{0.001, 5.0}, "thickness");
    field("skirting", self.skirting, Unit{"m"}, Range{0.0, 1.0}, "height of the skirting board");
    field("skirting_albedo", self.skirting_albedo, Unit{}, Range{0.0, 1.0}, "its reflectance");
    field("material", self.material, "surface");
  }
};

/// Floor covering laid in cells (tiles, boards); cell_x = 0 lays none.
struct FloorSpec {
  double albedo = 0.4;
  Grain grain = Grain::Speckle;
  double grain_contrast = 0.2, grain_size = 0.6;
  double blotch_contrast = 0.05, blotch_size = 3.0;
  double cell_x = 0.0, cell_y = 0.0, stagger = 0.0, yaw = 0.0;
  double gap = 0.004, gap_albedo = 0.12;
  double vary = 0.05;
  double tilt = 0.0;
  double reflection = 0.0, specular = 0.0, shininess = 60.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range share{0.0, 1.0};
    field("albedo", self.albedo, Unit{}, share, "mean share of light sent back");
    field("grain", self.grain, "kind of texture");
    field("grain_contrast", self.grain_contrast, Unit{}, share, "relative amplitude");
    field("grain_size", self.grain_size, Unit{"m"}, Range{0.01, 10.0}, "repeat of the texture");
    field("blotch_contrast", self.blotch_contrast, Unit{}, share, "wear and dirt, amplitude");
    field("blotch_size", self.blotch_size, Unit{"m"}, Range{0.1, 50.0}, "wear and dirt, repeat");
    field("cell_x", self.cell_x, Unit{"m"}, Range{0.0, 10.0}, "tile or board length; 0: no cells");
    field("cell_y", self.cell_y, Unit{"m"}, Range{0.0, 10.0}, "tile or board width");
    field("stagger", self.stagger, Unit{}, share, "random shift of each row, in cells");
    field("yaw", self.yaw, Unit{"rad"}, Range{-7.0, 7.0}, "direction in which it is laid");
    field("gap", self.gap, Unit{"m"}, Range{0.0, 0.1}, "grout or joint");
    field("gap_albedo", self.gap_albedo, Unit{}, share, "its reflectance");
    field("vary", self.vary, Unit{}, share, "brightness difference from cell to cell");
    field("tilt", self.tilt, Unit{"rad"}, Range{0.0, 0.05}, "slope difference from cell to cell");
    field("reflection", self.reflection, Unit{}, share, "mirror share seen straight down");
    field("specular", self.specular, Unit{}, Range{0.0, 10.0}, "strength of the lamps' highlights");
    field("shininess", self.shininess, Unit{}, Range{1.0, 5000.0}, "exponent of the highlights");
  }
};

struct PaintSpec {
  PaintKind kind = PaintKind::Line;
  Point from = Point::Zero(), to = Point::UnitX();
  double width = 0.08, x = 0.0, y = 0.0, yaw = 0.0, lx = 0.3, ly = 0.3, r = 0.2;
  double albedo = 0.7, wear = 0.1;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-100.0, 100.0}, length{0.0, 100.0};
    field("kind", self.kind, "line, patch (rectangle) or disc");
    field("from", self.from, "start of a line");
    field("to", self.to, "end of a line");
    field("width", self.width, Unit{"m"}, length, "width of a line");
    field("x", self.x, Unit{"m"}, place, "centre of a patch or disc");
    field("y", self.y, Unit{"m"}, place, "centre of a patch or disc");
    field("yaw", self.yaw, Unit{"rad"}, Range{-7.0, 7.0}, "turn of a patch");
    field("lx", self.lx, Unit{"m"}, length, "length of a patch");
    field("ly", self.ly, Unit{"m"}, length, "width of a patch");
    field("r", self.r, Unit{"m"}, length, "radius of a disc");
    field("albedo", self.albedo, Unit{}, Range{0.0, 1.0}, "reflectance");
    field("wear", self.wear, Unit{}, Range{0.0, 1.0}, "share rubbed off");
  }
};

/// A lamp: a level square panel, or a point where size is 0.
struct LampSpec {
  Eigen::Vector3d at{0.0, 0.0, 2.5};
  double energy = 0.6, size = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("at", self.at, "centre");
    field("energy", self.energy, Unit{}, Range{0.0, 100.0}, "light on the floor straight below");
    field("size", self.size, Unit{"m"}, Range{0.0, 5.0}, "side of the panel; 0 casts hard shadows");
  }
};

/// The camera as the driver states it, and by how much the mounting really differs.
struct CameraSpec {
  int width = 640, height = 480;
  double fx = 525.0, fy = 525.0, cx = 319.5, cy = 239.5;
  double x = 0.05, y = 0.0, z = 0.45, pitch = 0.4;
  std::vector<double> distortion;
  double pitch_error = 0.0, height_error = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-10.0, 10.0}, focal{10.0, 10000.0}, centre{-10000.0, 10000.0};
    field("width", self.width, Unit{"px"}, Range{16, 8192}, "image width");
    field("height", self.height, Unit{"px"}, Range{16, 8192}, "image height");
    field("fx", self.fx, Unit{"px"}, focal, "focal length");
    field("fy", self.fy, Unit{"px"}, focal, "focal length");
    field("cx", self.cx, Unit{"px"}, centre, "principal point");
    field("cy", self.cy, Unit{"px"}, centre, "principal point");
    field("x", self.x, Unit{"m"}, place, "place on the robot, forward");
    field("y", self.y, Unit{"m"}, place, "place on the robot, left");
    field("z", self.z, Unit{"m"}, Range{0.01, 10.0}, "height above the floor");
    field("pitch", self.pitch, Unit{"rad"}, Range{-1.5, 1.5}, "looking down is positive");
    field("distortion", self.distortion, "plumb_bob k1 k2 p1 p2 k3; none: a pinhole");
    field("pitch_error", self.pitch_error, Unit{"rad"}, Range{-0.2, 0.2},
          "true minus stated pitch");
    field("height_error", self.height_error, Unit{"m"}, Range{-1.0, 1.0},
          "true minus stated height");
  }
};

struct SensorSpec {
  double exposure = 1.0, full_well = 9000.0, read_noise = 8.0;
  double drift = 0.0, drift_period = 7.0, flicker = 0.0;
  double vignetting = 0.0, blur = 0.45;
  double exposure_time = 0.0, readout_time = 0.0;
  int blur_samples = 1;
  double shake = 0.0, shake_rate = 9.0;
  double stamp_error = 0.0, arrival_delay = 0.012;
  double drop_rate = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range second{0.0, 1.0};
    field("exposure", self.exposure, Unit{}, Range{0.01, 100.0}, "radiance times this; 1 is white");
    field("full_well", self.full_well, Unit{"e-"}, Range{10, 1e9},
          "electrons at white: shot noise");
    field("read_noise", self.read_noise, Unit{"e-"}, Range{0, 1e6}, "noise in the dark");
    field("drift", self.drift, Unit{}, Range{0, 0.9}, "slow relative change of the exposure");
    field("drift_period", self.drift_period, Unit{"s"}, Range{0.1, 1000.0}, "its period");
    field("flicker", self.flicker, Unit{}, Range{0, 0.5}, "relative change from frame to frame");
    field("vignetting", self.vignetting, Unit{}, Range{0, 1}, "light lost in the corners");
    field("blur", self.blur, Unit{"px"}, Range{0, 3}, "standard deviation of the lens blur");
    field("exposure_time", self.exposure_time, Unit{"s"}, second, "shutter time: motion blur");
    field("readout_time", self.readout_time, Unit{"s"}, second,
          "first to last row: rolling shutter");
    field("blur_samples", self.blur_samples, Unit{}, Range{1, 64},
          "instants averaged per exposure");
    field("shake", self.shake, Unit{"rad"}, Range{0, 0.1}, "amplitude of the pitch at full speed");
    field("shake_rate", self.shake_rate, Unit{"Hz"}, Range{0.1, 200.0}, "its frequency");
    field("stamp_error", self.stamp_error, Unit{"s"}, Range{-1.0, 1.0},
          "stamp minus the instant it stands for, the middle of the exposure and of the rows");
    field("arrival_delay", self.arrival_delay, Unit{"s"}, second,
          "stamp, or that instant if it is later, to arrival");
    field("drop_rate", self.drop_rate, Unit{}, Range{0, 1}, "share of frames that never arrive");
  }
};

struct SlipSpec {
  double at = 0.0, seconds = 1.0, grip = 0.5, turn_grip = 1.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("at", self.at, Unit{"s"}, Range{0, 1e5}, "start");
    field("seconds", self.seconds, Unit{"s"}, Range{0, 1e5}, "duration");
    field("grip", self.grip, Unit{}, Range{0, 1.5}, "true per turned metre");
    field("turn_grip", self.turn_grip, Unit{}, Range{0, 1.5}, "true per turned radian");
  }
};

struct OdometrySpec {
  double rate = 50.0, scale = 0.0, yaw_scale = 0.0, yaw_bias = 0.0;
  double speed_noise = 0.0, turn_noise = 0.0;
  double arrival_delay = 0.001, drop_rate = 0.0;
  std::vector<SlipSpec> slips;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("rate", self.rate, Unit{"Hz"}, Range{1, 1000}, "messages a second");
    field("scale", self.scale, Unit{}, Range{-0.5, 0.5}, "relative error of the distance");
    field("yaw_scale", self.yaw_scale, Unit{}, Range{-0.5, 0.5}, "relative error of the turn");
    field("yaw_bias", self.yaw_bias, Unit{"rad/s"}, Range{-1, 1}, "turn measured at rest");
    field("speed_noise", self.speed_noise, Unit{"m/s"}, Range{0, 1}, "white noise of each reading");
    field("turn_noise", self.turn_noise, Unit{"rad/s"}, Range{0, 1}, "white noise of each reading");
    field("arrival_delay", self.arrival_delay, Unit{"s"}, Range{0, 1}, "stamp to arrival");
    field("drop_rate", self.drop_rate, Unit{}, Range{0, 1}, "share of messages that never arrive");
    field("slips", self.slips, "stretches in which the wheels slip");
  }
};

struct DriveSegment {
  double seconds = 1.0, v = 0.0, w = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("seconds", self.seconds, Unit{"s"}, Range{0, 1e5}, "duration");
    field("v", self.v, Unit{"m/s"}, Range{-5, 5}, "commanded speed");
    field("w", self.w, Unit{"rad/s"}, Range{-10, 10}, "commanded turn rate");
  }
};

struct RobotSpec {
  double radius = 0.18, acceleration = 0.5, turn_acceleration = 2.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("radius", self.radius, Unit{"m"}, Range{0.01, 5}, "of the body, for collisions");
    field("acceleration", self.acceleration, Unit{"m/s^2"}, Range{0.01, 100}, "largest");
    field("turn_acceleration", self.turn_acceleration, Unit{"rad/s^2"}, Range{0.01, 1000},
          "largest");
  }
};

struct Scene {
  std::string name;
  int seed = 1;
  double rate = 10.0, start_stamp = 1700000000.0;
  double ambient = 0.3, ceiling = 0.8;
  CameraSpec camera;
  SensorSpec sensor;
  FloorSpec floor;
  std::vector<PaintSpec> paint;
  std::vector<ObstacleSpec> obstacles;
  std::vector<WallSpec> walls;
  std::vector<LampSpec> lamps;
  RobotSpec robot;
  OdometrySpec odometry;
  std::vector<DriveSegment> drive;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("name", self.name, "name of the scene");
    field("seed", self.seed, Unit{}, Range{0, 2147483647}, "of everything random");
    field("rate", self.rate, Unit{"Hz"}, Range{0.1, 1000}, "frames a second");
    field("start_stamp", self.start_stamp, Unit{"s"}, Range{1, 4e9}, "stamp of the first frame");
    field("ambient", self.ambient, Unit{}, Range{0, 10}, "light from everywhere");
    field("ceiling", self.ceiling, Unit{}, Range{0, 10}, "radiance of the ceiling and the sky");
    field("camera", self.camera, "lens and mounting");
    field("sensor", self.sensor, "imager");
    field("floor", self.floor, "covering");
    field("paint", self.paint, "markings on the floor, later ones over earlier ones");
    field("obstacles", self.obstacles, "what stands and lies about");
    field("walls", self.walls, "walls");
    field("lamps", self.lamps, "lamps");
    field("robot", self.robot, "body");
    field("odometry", self.odometry, "errors of the wheel odometry");
    field("drive", self.drive, "commands, one after the other");
  }
};

/// Seconds of the scripted drive.
double driveDuration(const Scene& scene);

}  // namespace ipm_mapping::sim

namespace ipm_mapping {
template <>
inline constexpr std::array<const char*, 7> enum_names<sim::Grain>{
    "none", "speckle", "clouds", "wood", "fibre", "concrete", "marble"};
template <>
inline constexpr std::array<const char*, 4> enum_names<sim::Pattern>{"none", "bands", "carton",
                                                                     "books"};
template <>
inline constexpr std::array<const char*, 8> enum_names<sim::ObstacleKind>{
    "box", "cylinder", "cone", "legs", "heap", "cable", "pallet", "shelf"};
template <>
inline constexpr std::array<const char*, 3> enum_names<sim::PaintKind>{"line", "patch", "disc"};
}  // namespace ipm_mapping
