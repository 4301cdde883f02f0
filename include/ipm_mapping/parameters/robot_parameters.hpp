#pragma once
// Parameters of the robot: where the camera sits, and how answers leave the package.

#include <string>

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

/// Camera pose used where tf does not know it, calibration used where no camera_info comes.
struct CameraParameters {
  bool pose_from_tf = true;
  double x = 0.05;
  double y = 0.0;
  double z = 0.45;
  double pitch = 0.42;
  double yaw = 0.0;
  double roll = 0.0;
  double image_time_offset = 0.0;
  std::string calibration_file;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("pose_from_tf", self.pose_from_tf,
          "take the camera pose from tf; x ... roll serve while tf does not know it");
    field("x", self.x, Unit{"m"}, Range{-10.0, 10.0}, "camera position in base, forward");
    field("y", self.y, Unit{"m"}, Range{-10.0, 10.0}, "camera position in base, left");
    field("z", self.z, Unit{"m"}, Range{0.01, 10.0}, "camera height over the floor");
    field("pitch", self.pitch, Unit{"rad"}, Range{-1.5, 1.5}, "camera turned down by this");
    field("yaw", self.yaw, Unit{"rad"}, Range{-3.15, 3.15}, "camera turned left by this");
    field("roll", self.roll, Unit{"rad"}, Range{-3.15, 3.15}, "camera rolled about its axis");
    field("image_time_offset", self.image_time_offset, Unit{"s"}, Range{-5.0, 5.0},
          "added to every image stamp before odometry is asked");
    field("calibration_file", self.calibration_file,
          "camera_info as YAML, for cameras without a camera_info topic");
  }
};

/// How obstacles leave as scan and clouds.
struct OutputParameters {
  double contact_z = 0.1;
  double free_step = 0.05;
  double scan_range_max = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("contact_z", self.contact_z, Unit{"m"}, Range{0.0, 2.0},
          "height at which contact and free points are published: costmaps drop points at or below "
          "0");
    field("free_step", self.free_step, Unit{"m"}, Range{0.01, 1.0},
          "distance between the points of `free` along a bearing");
    field("scan_range_max", self.scan_range_max, Unit{"m"}, Range{0.0, 100.0},
          "range_max of the scan; 0: the range that was looked at");
  }
};

}  // namespace ipm_mapping
