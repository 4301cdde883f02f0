#pragma once
// Parameters of the nodelets themselves: frames, topics' sources, publishing.

#include <string>

#include "ipm_mapping/parameters/field.hpp"
#include "ipm_mapping/parameters/map_parameters.hpp"

namespace ipm_mapping {

enum class PoseOrigin { Topic, Tf };
template <>
inline constexpr std::array<const char*, 2> enum_names<PoseOrigin>{"topic", "tf"};

/// Where frames and poses come from: nodelets that take camera images.
struct SourceParameters {
  std::string base_frame;
  std::string odom_frame;
  PoseOrigin odometry_source = PoseOrigin::Topic;
  double patience = 1.0;
  int queue = 10;
  int waiting_frames = 32;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("base_frame", self.base_frame,
          "robot frame on the floor; empty: the child frame of the odometry, or base_footprint");
    field("odom_frame", self.odom_frame,
          "frame of the robot's poses; empty: the frame of the odometry, or odom");
    field("odometry_source", self.odometry_source,
          "topic: nav_msgs/Odometry on odom; tf: base_frame in odom_frame, whenever tf changes");
    field("patience", self.patience, Unit{"s"}, Range{0.0, 60.0},
          "how long the first images wait for camera_info and tf before the calibration file and "
          "the stated camera pose are taken");
    field("queue", self.queue, Unit{"messages"}, Range{1, 1000}, "length of the image queue");
    field("waiting_frames", self.waiting_frames, Unit{"frames"}, Range{1, 1000},
          "images that wait for odometry to pass their stamps; more are dropped, oldest first");
  }
};

/// A detector in one piece as localiser: what the floor shows to be wrong with the wheels, as tf.
struct FloorLocaliserParameters {
  std::string map_frame;
  double transform_tolerance = 0.2;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field(
        "map_frame", self.map_frame,
        "publishes the odometry's frame in this one, usually map, as tf: the wheels, and what the "
        "floor shows to be wrong with them; empty: no tf");
    field("transform_tolerance", self.transform_tolerance, Unit{"s"}, Range{0.0, 10.0},
          "such a transform is dated so far into the future, so that whoever asks for the present "
          "finds one until the next image");
  }
};

/// How camera images come: whoever subscribes to image_raw, be it only for the overlay.
struct TransportParameters {
  std::string image_transport = "raw";

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("image_transport", self.image_transport,
          "raw, compressed, or another image_transport plugin that is installed");
  }
};

/// Links between nodelets.
struct StageParameters {
  int queue = 32;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("queue", self.queue, Unit{"messages"}, Range{1, 1000},
          "messages that may wait for this stage; more are dropped, oldest first");
  }
};

/// How the mapper publishes and keeps its map.
struct MapperParameters {
  std::string frame = "odom";
  std::string global_frame;
  MapCorrection correction = MapCorrection::Follow;
  int correction_frames = 600;
  double publish_rate = 5.0;
  double full_map_period = 1.0;
  std::string directory = "~/.ros/ipm_mapping";
  std::string initial_map;
  double autosave_period = 0.0;
  std::string autosave_name = "autosave";
  bool clear_on_clock_jump = false;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("frame", self.frame,
          "frame of the empty map until obstacles say in which frame they are");
    field(
        "global_frame", self.global_frame,
        "frame of the map when a localiser places the odometry's frame in it by tf (usually map); "
        "empty: the map is in the odometry's frame");
    field("correction", self.correction,
          "what a correction by the localiser does to the frames since the one before it. follow: "
          "all move by it; spread: by the share of the way driven until then, for odometry that "
          "drifts much between two corrections; keep: they stay where they were");
    field("correction_frames", self.correction_frames, Unit{"frames"}, Range{1, 10000},
          "so many of them are remembered to be moved, older ones stay");
    field("publish_rate", self.publish_rate, Unit{"Hz"}, Range{0.0, 100.0},
          "how often changes are published as map_updates; 0: after every frame");
    field("full_map_period", self.full_map_period, Unit{"s"}, Range{0.0, 3600.0},
          "a changed map is published as a whole at most this often, and always when it grows");
    field("directory", self.directory, "folder below which maps are saved, and nowhere else");
    field("initial_map", self.initial_map, "map_server YAML file to start from; empty: none");
    field("autosave_period", self.autosave_period, Unit{"s"}, Range{0.0, 86400.0},
          "how often the map is saved by itself; 0: never");
    field("autosave_name", self.autosave_name, "name of that map inside the folder");
    field("clear_on_clock_jump", self.clear_on_clock_jump,
          "forget the map when the clock jumps back, as with rosbag play --loop");
  }
};

}  // namespace ipm_mapping
