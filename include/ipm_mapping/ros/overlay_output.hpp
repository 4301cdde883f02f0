#pragma once

#include <image_transport/publisher.h>

#include <deque>
#include <optional>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/ros/image_subscriber.hpp"

namespace ipm_mapping {

/// Publishes the answer drawn over the camera picture it was made from, only where somebody looks.
void publishOverlay(const image_transport::Publisher& publisher, GrayView raw,
                    const Obstacles& obstacles, const std_msgs::Header& header);

/// Camera pictures for a stage that only gets their results: subscribes while somebody looks, and
/// finds the picture that the camera sent with a stamp among the last ones.
class CameraPictures {
 public:
  CameraPictures(const ros::NodeHandle& node, const ros::NodeHandle& private_node);

  void want(bool wanted);
  /// The picture stays valid as long as `picture` lives; false when it is not there.
  [[nodiscard]] bool find(const ros::Time& image_stamp, GrayPicture& picture) const;

 private:
  static constexpr std::size_t kept = 64;

  bool wanted_ = false;
  std::deque<CameraMessage> messages_;
  ImageSubscriber images_;
};

}  // namespace ipm_mapping
