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
#include "ipm_mapping_sim/scene_things.hpp"

namespace ipm_mapping::sim {

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
