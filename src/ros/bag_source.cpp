#include "ipm_mapping/ros/bag_source.hpp"

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/view.h>
#include <tf2/buffer_core.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "ipm_mapping/ros/header_stamp.hpp"
#include "ipm_mapping/ros/odometry_source.hpp"

namespace ipm_mapping {
namespace {

const std::vector<std::string> image_types{"sensor_msgs/Image", "sensor_msgs/CompressedImage"};

std::string joined(const std::set<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all.empty() ? "none" : all;
}

/// Topics of a bag by type.
std::map<std::string, std::set<std::string>> topicsByType(const rosbag::Bag& bag) {
  std::map<std::string, std::set<std::string>> found;
  rosbag::View view(bag);
  for (const rosbag::ConnectionInfo* connection : view.getConnections())
    found[connection->datatype].insert(connection->topic);
  return found;
}

/// First message of a topic that can be read as Message.
template <class Message>
boost::shared_ptr<Message> firstOf(const rosbag::Bag& bag, const std::string& topic) {
  if (topic.empty()) return nullptr;
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  for (const rosbag::MessageInstance& message : view)
    if (auto typed = message.instantiate<Message>()) return typed;
  return nullptr;
}

std::string siblingCameraInfo(const std::string& image_topic) {
  std::string base = image_topic;
  const std::string suffix = "/compressed";
  if (base.size() > suffix.size() &&
      base.compare(base.size() - suffix.size(), suffix.size(), suffix) == 0)
    base.resize(base.size() - suffix.size());
  return base.substr(0, base.rfind('/') + 1) + "camera_info";
}

BagSource::Image imageOf(const rosbag::MessageInstance& message) {
  BagSource::Image image;
  GrayPicture picture;
  Refusal refusal;
  if (const auto raw = message.instantiate<sensor_msgs::Image>()) {
    image.stamp = stampOf(raw->header);
    refusal = toGray(raw, picture);
  } else if (const auto compressed = message.instantiate<sensor_msgs::CompressedImage>()) {
    image.stamp = stampOf(compressed->header);
    refusal = toGray(*compressed, picture);
  } else {
    refusal = "message of type " + message.getDataType() + " is not an image";
  }
  if (refusal)
    image.refusal = *refusal;
  else
    image.picture = picture;
  return image;
}

}  // namespace

BagSource::BagSource(const std::string& path, const BagTopics& wanted) : path_(path) {
  try {
    bag_.open(path, rosbag::bagmode::Read);
  } catch (const std::exception& error) {
    throw BagError("cannot read bag '" + path + "': " + error.what());
  }
  resolveTopics(wanted);
}

std::string BagSource::resolve(const std::string& wanted, const std::string& usual,
                               const std::vector<std::string>& types, const char* what,
                               const char* option) const {
  const auto by_type = topicsByType(bag_);
  std::set<std::string> fitting;
  for (const std::string& type : types) {
    const auto found = by_type.find(type);
    if (found != by_type.end()) fitting.insert(found->second.begin(), found->second.end());
  }
  if (!wanted.empty()) {
    if (fitting.count(wanted) != 0) return wanted;
    throw BagError("bag '" + path_ + "' has no " + what + " on topic '" + wanted +
                   "' (there is: " + joined(fitting) + "); choose with " + option);
  }
  if (fitting.count(usual) != 0) return usual;
  if (fitting.size() == 1) return *fitting.begin();
  if (fitting.empty()) return {};
  throw BagError("bag '" + path_ + "' has several " + what + " topics (" + joined(fitting) +
                 "); choose with " + option);
}

void BagSource::resolveTopics(const BagTopics& wanted) {
  if (rosbag::View(bag_).size() == 0) throw BagError("bag '" + path_ + "' is empty");
  topics_.image =
      resolve(wanted.image, "/camera/rgb/image_raw", image_types, "image", "--image-topic");
  if (topics_.image.empty())
    throw BagError("bag '" + path_ +
                   "' has no image topic; record sensor_msgs/Image or CompressedImage");
  topics_.odometry =
      resolve(wanted.odometry, "/odom", {"nav_msgs/Odometry"}, "odometry", "--odom-topic");
  if (topics_.odometry.empty())
    throw BagError("bag '" + path_ + "' has no odometry topic; record nav_msgs/Odometry");
  const std::string sibling = siblingCameraInfo(topics_.image);
  topics_.camera_info = resolve(wanted.camera_info, sibling, {"sensor_msgs/CameraInfo"},
                                "camera_info", "--camera-info-topic");
}

void BagSource::read(const Handlers& handlers) const {
  rosbag::View view(bag_,
                    rosbag::TopicQuery(std::vector<std::string>{topics_.image, topics_.odometry}));
  const double total = std::max<double>(view.size(), 1.0);
  double done = 0.0;
  for (const rosbag::MessageInstance& message : view) {
    if (handlers.done && handlers.done()) return;
    if (message.getTopic() == topics_.image) {
      Image image = imageOf(message);
      image.arrival = message.getTime().toSec();
      handlers.image(image);
      if (handlers.progress) handlers.progress(done / total);
    } else if (const auto odometry = message.instantiate<nav_msgs::Odometry>()) {
      handlers.odometry(stampOf(odometry->header), message.getTime().toSec(), *odometry);
    }
    done += 1.0;
  }
  if (handlers.progress) handlers.progress(1.0);
}

std::optional<sensor_msgs::CameraInfo> BagSource::cameraInfo() const {
  const auto info = firstOf<sensor_msgs::CameraInfo>(bag_, topics_.camera_info);
  if (!info) return std::nullopt;
  return *info;
}

std::string BagSource::frameOfImages() const {
  if (const auto raw = firstOf<sensor_msgs::Image>(bag_, topics_.image))
    return withoutSlash(raw->header.frame_id);
  if (const auto compressed = firstOf<sensor_msgs::CompressedImage>(bag_, topics_.image))
    return withoutSlash(compressed->header.frame_id);
  return {};
}

std::string BagSource::baseFrame() const {
  const auto odometry = firstOf<nav_msgs::Odometry>(bag_, topics_.odometry);
  return odometry ? withoutSlash(odometry->child_frame_id) : std::string();
}

std::optional<CameraPose> BagSource::cameraPose() const {
  const std::string camera = frameOfImages(), base = baseFrame();
  if (camera.empty() || base.empty()) return std::nullopt;
  tf2::BufferCore buffer;
  rosbag::View view(bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf_static", "/tf"}));
  for (const rosbag::MessageInstance& message : view) {
    const auto tf = message.instantiate<tf2_msgs::TFMessage>();
    if (!tf) continue;
    for (const geometry_msgs::TransformStamped& transform : tf->transforms)
      buffer.setTransform(transform, "bag", message.getTopic() == "/tf_static");
    if (buffer.canTransform(base, camera, ros::Time(0)))
      return tf2::transformToEigen(buffer.lookupTransform(base, camera, ros::Time(0)));
  }
  return std::nullopt;
}

}  // namespace ipm_mapping
