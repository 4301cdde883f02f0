#pragma once

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/ros/images.hpp"

namespace ipm_mapping {

/// An input that cannot be used: what() says in one line what is missing and what to do about it.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which topics to read; empty ones are found by name and type.
struct BagTopics {
  std::string image;
  std::string camera_info;
  std::string odometry;
};

/// Images and odometry of one bag, in the order in which they were recorded.
class BagSource {
 public:
  /// Opens the bag and resolves the topics; throws BagError.
  BagSource(const std::string& path, const BagTopics& wanted);

  struct Image {
    double stamp = 0.0;    ///< of the header, seconds
    double arrival = 0.0;  ///< when it was recorded, seconds
    std::optional<GrayPicture> picture;
    std::string refusal;  ///< why there is no picture
  };
  struct Handlers {
    std::function<void(const Image&)> image;
    std::function<void(double stamp, double arrival, const nav_msgs::Odometry&)> odometry;
    std::function<void(double share)> progress;  ///< 0..1
    std::function<bool()> done = {};             ///< true ends the reading early
  };
  void read(const Handlers& handlers) const;

  [[nodiscard]] const BagTopics& topics() const { return topics_; }
  /// First camera_info of the bag; nothing without the topic or a message.
  [[nodiscard]] std::optional<sensor_msgs::CameraInfo> cameraInfo() const;
  /// Pose of the camera that the bag's tf knows: from the child frame of odometry to the frame of
  /// the images. Nothing where tf does not connect them.
  [[nodiscard]] std::optional<CameraPose> cameraPose() const;
  /// Frame of the images, child frame of odometry; empty where the messages name none.
  [[nodiscard]] std::string frameOfImages() const;
  [[nodiscard]] std::string baseFrame() const;

 private:
  void resolveTopics(const BagTopics& wanted);
  [[nodiscard]] std::string resolve(const std::string& wanted, const std::string& usual,
                                    const std::vector<std::string>& types, const char* what,
                                    const char* option) const;

  std::string path_;
  mutable rosbag::Bag bag_;
  BagTopics topics_;
};

}  // namespace ipm_mapping
