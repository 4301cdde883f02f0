#pragma once
// What the rostests share: plays the synthetic robot to nodelets in another process and listens to
// them as any consumer would.

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ipm_mapping/ObstacleArray.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "synthetic_robot.hpp"

namespace ipm_mapping {

/// Spins until `done`; false when it took longer than `seconds` of wall time.
inline bool waitFor(const std::function<bool()>& done, double seconds = 60.0) {
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(seconds);
  while (ros::ok() && !done()) {
    if (ros::WallTime::now() > end) return false;
    ros::spinOnce();
    ros::WallDuration(0.002).sleep();
  }
  return ros::ok();
}

/// Everything that came in on one topic.
template <class Message>
class Collected {
 public:
  Collected(ros::NodeHandle& node, const std::string& topic) {
    subscriber_ = node.subscribe<Message>(
        topic, 1000, [this](const boost::shared_ptr<const Message>& m) { all.push_back(m); });
  }
  [[nodiscard]] bool connected() const { return subscriber_.getNumPublishers() > 0; }
  [[nodiscard]] std::size_t size() const { return all.size(); }
  [[nodiscard]] const Message& last() const { return *all.back(); }

  std::vector<boost::shared_ptr<const Message>> all;

 private:
  ros::Subscriber subscriber_;
};

/// Nothing of what comes next on these topics is missed.
template <class... Messages>
[[nodiscard]] bool waitForPublishers(const Collected<Messages>&... topics) {
  return waitFor([&] { return (topics.connected() && ...); });
}

/// Counters of a nodelet as /diagnostics shows them; by its name, or its namespace and name where
/// there are several ("left/mapper").
class Diagnostics {
 public:
  explicit Diagnostics(ros::NodeHandle& node) {
    subscriber_ = node.subscribe("/diagnostics", 100, &Diagnostics::onMessage, this);
  }
  /// -1 where the nodelet never said anything about it.
  [[nodiscard]] double value(const std::string& nodelet, const std::string& key) const {
    const auto found = values_.find(nodelet + "/" + key);
    return found == values_.end() ? -1.0 : found->second;
  }
  [[nodiscard]] int level(const std::string& nodelet) const { return levels_.at(nodelet); }
  /// Whether its last status has this level, and these words in its sentence.
  [[nodiscard]] bool shows(const std::string& nodelet, int level, const std::string& words) const {
    const auto found = now_.find(nodelet);
    return found != now_.end() && levels_.at(nodelet) == level &&
           found->second.find(words) != std::string::npos;
  }
  /// That status in words, for failures.
  [[nodiscard]] std::string status(const std::string& nodelet) const {
    const auto found = now_.find(nodelet);
    return found == now_.end()
               ? nodelet + " never said anything"
               : nodelet + ": " + std::to_string(levels_.at(nodelet)) + ", " + found->second;
  }
  [[nodiscard]] bool waitFor(const std::string& nodelet, const std::string& key, double expected) {
    return ipm_mapping::waitFor([&] { return value(nodelet, key) == expected; });
  }

  /// Every (level, sentence) that a nodelet ever showed.
  std::map<std::string, std::map<std::string, int>> sentences;
  /// How often a nodelet reported each of its faults, by sentence.
  std::map<std::string, std::map<std::string, long>> faults;

 private:
  void onMessage(const diagnostic_msgs::DiagnosticArrayConstPtr& message) {
    for (const auto& status : message->status) {
      const std::string path = status.name.substr(0, status.name.find(':'));
      take(status, path);
      if (path.find('/') != std::string::npos) take(status, path.substr(path.rfind('/') + 1));
    }
  }
  void take(const diagnostic_msgs::DiagnosticStatus& status, const std::string& nodelet) {
    levels_[nodelet] = status.level;
    now_[nodelet] = status.message;
    sentences[nodelet][status.message] = status.level;
    for (const auto& pair : status.values)
      if (pair.key.rfind("fault_", 0) == 0)
        addFault(nodelet, pair.value);
      else
        values_[nodelet + "/" + pair.key] = std::strtod(pair.value.c_str(), nullptr);
  }
  /// "3 times: sentence"
  void addFault(const std::string& nodelet, const std::string& text) {
    const std::string words = " times: ";
    const std::size_t at = text.find(words);
    if (at == std::string::npos) throw std::runtime_error("a fault without its count: " + text);
    faults[nodelet][text.substr(at + words.size())] += std::stol(text.substr(0, at));
  }
  ros::Subscriber subscriber_;
  std::map<std::string, double> values_;
  std::map<std::string, int> levels_;
  std::map<std::string, std::string> now_;
};

/// The robot's topics, in the names that the .test files remap the nodelets to.
class RobotTopics {
 public:
  explicit RobotTopics(ros::NodeHandle& node)
      : images_(node.advertise<sensor_msgs::Image>("/robot/image_raw", 1000)),
        infos_(node.advertise<sensor_msgs::CameraInfo>("/robot/camera_info", 1000)),
        odometry_(node.advertise<nav_msgs::Odometry>("/robot/odom", 1000)),
        tf_(node.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true)) {}

  /// The chain is awake, and what was latched has arrived.
  [[nodiscard]] bool waitForListeners() const {
    const bool awake = waitFor([this] {
      return images_.getNumSubscribers() > 0 && odometry_.getNumSubscribers() > 0 &&
             infos_.getNumSubscribers() > 0 && tf_.getNumSubscribers() > 0;
    });
    waitFor([] { return false; }, 0.3);
    return awake;
  }
  void tellTf() {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(robot.cameraTransform());
    tf_.publish(message);
  }

  /// Who listens to the images.
  [[nodiscard]] int listeners() const { return static_cast<int>(images_.getNumSubscribers()); }

  void sendInfo(double t) { infos_.publish(robot.cameraInfo(stamp(t))); }
  void sendInfo(const sensor_msgs::CameraInfo& info) { infos_.publish(info); }
  void sendOdometry(double t) { odometry_.publish(robot.odometry(stamp(t), robot.pose(t))); }
  void sendOdometry(const nav_msgs::Odometry& odometry) { odometry_.publish(odometry); }
  void sendImage(double t) { images_.publish(robot.image(stamp(t), robot.pose(t))); }
  void sendImage(const sensor_msgs::ImagePtr& image) { images_.publish(image); }

  /// Frames `from` ... `to` - 1 with their calibration, and odometry around them.
  void play(int from, int to, bool with_images = true) {
    for (int i = from; i < to; ++i) {
      sendInfo(robot.frameTime(i));
      if (with_images) sendImage(robot.frameTime(i));
      for (int k = 5 * i; k < 5 * (i + 1); ++k) sendOdometry(robot.odometryTime(k));
      ros::spinOnce();
    }
    sendOdometry(robot.frameTime(to));
  }

  [[nodiscard]] double stamp(double t) const { return robot.first_stamp + time_shift + t; }

  SyntheticRobot robot;
  double time_shift = 0.0;

 private:
  ros::Publisher images_, infos_, odometry_, tf_;
};

}  // namespace ipm_mapping
