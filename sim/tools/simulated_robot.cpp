// Publishes what a robot with a camera and wheel odometry publishes, and the truth beside it.

#include <geometry_msgs/Twist.h>
#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <iostream>
#include <thread>

#include "ipm_mapping_sim/live_motion.hpp"
#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ros/help.hpp"
#include "ros/messages.hpp"

namespace ipm_mapping::sim {
namespace {

constexpr double kMapResolution = 0.05;
constexpr const char* kUsage =
    "usage: simulated_robot _scene:=SCENE.yaml\n"
    "A node: listens to cmd_vel, publishes camera/rgb/image_raw, camera/rgb/camera_info, odom, tf\n"
    "and the truth as ground_truth/odom and ground_truth/map. Needs a ROS master.\n";

class SimulatedRobot {
 public:
  SimulatedRobot(ros::NodeHandle& node, const Scene& scene)
      : scene_(scene),
        camera_(scene_),
        motion_(scene_, camera_.stage().footprints()),
        image_(node.advertise<sensor_msgs::Image>("camera/rgb/image_raw", 2)),
        camera_info_(node.advertise<sensor_msgs::CameraInfo>("camera/rgb/camera_info", 2)),
        odometry_(node.advertise<nav_msgs::Odometry>("odom", 50)),
        truth_(node.advertise<nav_msgs::Odometry>("ground_truth/odom", 50)),
        map_(node.advertise<nav_msgs::OccupancyGrid>("ground_truth/map", 1, true)),
        command_(node.subscribe("cmd_vel", 1, &SimulatedRobot::onCommand, this)),
        start_(ros::Time::now()) {
    geometry_msgs::TransformStamped origin;
    origin.header.stamp = start_;
    origin.header.frame_id = kWorldFrame;
    origin.child_frame_id = kOdomFrame;
    origin.transform.rotation.w = 1.0;
    fixed_frames_.sendTransform({origin, cameraTransform(scene_, start_)});
    map_.publish(trueMap(camera_.stage().footprints(), kMapResolution, start_));
    wheels_timer_ = node.createTimer(ros::Duration(1.0 / scene_.odometry.rate),
                                     &SimulatedRobot::onWheels, this);
    camera_thread_ = std::thread([this] { takePictures(); });
  }

  ~SimulatedRobot() {
    stopping_ = true;
    camera_thread_.join();
  }

 private:
  void onCommand(const geometry_msgs::Twist& twist) {
    motion_.command({twist.linear.x, twist.angular.z});
  }

  void onWheels(const ros::TimerEvent&) {
    const ros::Time now = ros::Time::now();
    const double time = (now - start_).toSec();
    const OdometryReading reading = motion_.advance(time);
    truth_.publish(odometryMessage(motion_.pose(time), motion_.wheels(time), now, kWorldFrame));
    if (motion_.touching()) ROS_WARN_THROTTLE(2.0, "the robot touches an obstacle");
    if (!reading.arrives) return;
    const nav_msgs::Odometry odometry =
        odometryMessage(reading.pose, reading.speed, now, kOdomFrame);
    odometry_.publish(odometry);
    frames_.sendTransform(transformOf(odometry));
  }

  /// A picture is due every 1 / rate seconds; a machine that is too slow leaves some out.
  void takePictures() {
    const Moving robot{[this](double t) { return motion_.pose(t); },
                       [this](double t) { return motion_.wheels(t); }};
    const double exposed = 0.5 * (scene_.sensor.exposure_time + scene_.sensor.readout_time);
    std::vector<std::uint8_t> grey;
    int frame = 0;
    while (!stopping_ && ros::ok()) {
      const double time = frame / scene_.rate;
      // Odometry up to the end of the exposure is there one reading later.
      const double late = std::max(0.0, scene_.sensor.stamp_error);
      const double ready = time + late + exposed + 1.5 / scene_.odometry.rate;
      const double wait = ready - (ros::Time::now() - start_).toSec();
      if (wait > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(wait));
      camera_.capture(frame, time, robot, grey);
      const ros::Time stamp = start_ + ros::Duration(time + scene_.sensor.stamp_error);
      camera_info_.publish(cameraInfoMessage(scene_, stamp));
      image_.publish(imageMessage(scene_, stamp, std::move(grey)));
      frame = std::max(frame + 1, nextFrame());
    }
  }

  [[nodiscard]] int nextFrame() {
    const double now = (ros::Time::now() - start_).toSec();
    const int due = static_cast<int>(now * scene_.rate);
    if (due > last_due_ + 1) {
      ROS_WARN_THROTTLE(10.0, "rendering is slower than %.3g frames/s: some are left out",
                        scene_.rate);
    }
    return last_due_ = due;
  }

  Scene scene_;
  SimulatedCamera camera_;
  LiveMotion motion_;
  ros::Publisher image_, camera_info_, odometry_, truth_, map_;
  ros::Subscriber command_;
  tf2_ros::TransformBroadcaster frames_;
  tf2_ros::StaticTransformBroadcaster fixed_frames_;
  ros::Time start_;
  ros::Timer wheels_timer_;
  std::atomic<bool> stopping_{false};
  int last_due_ = 0;
  std::thread camera_thread_;
};

}  // namespace
}  // namespace ipm_mapping::sim

int main(int argc, char** argv) {
  if (ipm_mapping::sim::asksForHelp(argc, argv)) {
    std::cout << ipm_mapping::sim::kUsage;
    return 0;
  }
  ros::init(argc, argv, "simulated_robot");
  ros::NodeHandle node;
  const ros::NodeHandle options("~");
  try {
    const auto path = options.param<std::string>("scene", "");
    if (path.empty()) throw std::runtime_error("set the parameter ~scene to a scene file");
    ros::Time::waitForValid();
    ipm_mapping::sim::SimulatedRobot robot(node, ipm_mapping::sim::loadScene(path));
    ros::spin();
    return 0;
  } catch (const std::exception& error) {
    ROS_FATAL("simulated_robot: %s", error.what());
    return 1;
  }
}
