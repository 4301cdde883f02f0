#include "ipm_mapping/ros/live_run.hpp"

#include <ros/ros.h>

#include "ipm_mapping/ros/frame_source.hpp"
#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

std::string orElse(const std::string& given, const std::string& usual) {
  return given.empty() ? usual : given;
}

/// The names that FrameSource subscribes to, led to the robot's topics.
ros::M_string remappings(const BagTopics& topics) {
  const std::string image = orElse(topics.image, "/camera/rgb/image_raw");
  const std::string beside = image.substr(0, image.rfind('/') + 1) + "camera_info";
  return {{"image_raw", image},
          {"camera_info", orElse(topics.camera_info, beside)},
          {"odom", orElse(topics.odometry, "/odom")}};
}

Parameters withOptions(const OfflineOptions& options) {
  Parameters parameters = options.parameters;
  CameraParameters& camera = parameters.camera;
  if (!options.calibration_file.empty()) camera.calibration_file = options.calibration_file;
  if (options.camera_pose) {
    const auto& [x, y, z, pitch] = *options.camera_pose;
    camera.x = x;
    camera.y = y;
    camera.z = z;
    camera.pitch = pitch;
    camera.yaw = camera.roll = 0.0;
    camera.pose_from_tf = false;
  }
  return parameters;
}

/// Without an image nothing else has been said.
std::string nothingCame(const LiveOptions& live, const FrameSource& source, std::uint64_t images) {
  if (images == 0)
    return sentence("no frame came through in ", live.seconds, " s: no image on ",
                    source.imageTopic(), "; choose with --image-topic and --image-transport");
  return sentence("no frame came through in ", live.seconds, " s: ", images, " images on ",
                  source.imageTopic(), ", odometry expected on ", source.odometryTopic(),
                  "; see what was said above, and --odom-topic, --camera-info, --camera-pose");
}

}  // namespace

std::string runLive(const std::string& node_name, const OfflineOptions& options,
                    const LiveOptions& live, Detector& detector) {
  ros::init(remappings(options.topics), node_name, ros::init_options::AnonymousName);
  if (!ros::master::check())
    throw BagError("no ROS master answers at " + ros::master::getURI() + "; start the robot first");
  ros::NodeHandle node, private_node("~");
  private_node.setParam("image_transport", live.image_transport);
  StageMonitor monitor(node, private_node, node_name);
  Obstacles obstacles;
  int frames = 0;
  FrameSource source(node, private_node, withOptions(options), monitor,
                     {[&](const CameraModel& camera, const CameraPose& T_base_camera) {
                        detector.setCamera(camera, T_base_camera);
                      },
                      [&](Restart) { detector.reset(); },
                      [&](const Frame& frame, const FrameInfo&) {
                        ++frames;
                        return detector.process(frame, obstacles);
                      },
                      [&] { return detector.timeOffset(); }});
  source.start();
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(live.seconds);
  while (ros::ok() && ros::WallTime::now() < end)
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
  source.stop();
  if (frames == 0) throw BagError(nothingCame(live, source, monitor.counter("received")));
  return options.camera_pose ? "command line" : source.poseSource();
}

}  // namespace ipm_mapping
