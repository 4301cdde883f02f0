#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <functional>
#include <string>

#include "ipm_mapping/ros/images.hpp"

namespace ipm_mapping {

/// A camera message as it came: exactly one of the two is set.
struct CameraMessage {
  sensor_msgs::ImageConstPtr raw;
  sensor_msgs::CompressedImageConstPtr compressed;

  [[nodiscard]] const std_msgs::Header& header() const {
    return raw ? raw->header : compressed->header;
  }
  [[nodiscard]] Refusal toGray(GrayPicture& picture) const {
    return raw ? ipm_mapping::toGray(raw, picture) : ipm_mapping::toGray(*compressed, picture);
  }
};

/// Camera images through image_transport. Where the plugin for `compressed` is not installed, the
/// compressed topic is decoded here.
class ImageSubscriber {
 public:
  using Handler = std::function<void(const CameraMessage&)>;

  /// The transport is the private parameter `image_transport`, `raw` by default.
  ImageSubscriber(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                  const std::string& topic, int queue, Handler handler);

  void start();
  void stop();
  /// Topic that is (or would be) subscribed to.
  [[nodiscard]] const std::string& topic() const { return topic_; }
  /// Another transport by which somebody offers these images; empty if nobody does. Asks the
  /// master.
  [[nodiscard]] std::string transportToTry() const;

 private:
  bool startTransport();
  void startDecoding();

  ros::NodeHandle node_, private_node_;
  std::string base_, transport_, topic_;
  std::uint32_t queue_;
  Handler handler_;
  image_transport::ImageTransport image_transport_;
  image_transport::Subscriber through_transport_;
  ros::Subscriber decoded_here_;
};

}  // namespace ipm_mapping
