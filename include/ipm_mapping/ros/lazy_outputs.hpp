#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <functional>
#include <string>
#include <vector>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// The topics of a stage that works only while somebody listens to one of them.
class LazyOutputs {
 public:
  /// `change(true)` when the first listener comes, `change(false)` when the last one leaves.
  explicit LazyOutputs(std::function<void(bool awake)> change) : change_(std::move(change)) {}

  template <class Message>
  ros::Publisher advertise(ros::NodeHandle& node, const std::string& topic,
                           std::uint32_t queue = 10) {
    const auto changed = [this](const ros::SingleSubscriberPublisher&) { update(); };
    publishers_.push_back(node.advertise<Message>(topic, queue, changed, changed));
    return publishers_.back();
  }
  image_transport::Publisher advertiseImage(ros::NodeHandle& node, const std::string& topic) {
    const auto changed = [this](const image_transport::SingleSubscriberPublisher&) { update(); };
    pictures_.push_back(
        image_transport::ImageTransport(node).advertise(topic, 1, changed, changed));
    return pictures_.back();
  }
  /// Whoever listens: `change` is not called any more, the caller has woken the stage himself.
  void stayAwake() { awake_ = always_ = true; }
  [[nodiscard]] bool awake() const { return awake_; }

 private:
  void update();

  std::function<void(bool)> change_;
  std::vector<ros::Publisher> publishers_;
  std::vector<image_transport::Publisher> pictures_;
  bool awake_ = false, always_ = false;
};

/// A copy of a picture that a stage keeps for itself, only where somebody looks.
void publishPicture(const image_transport::Publisher& publisher, GrayView picture,
                    const std_msgs::Header& header);

}  // namespace ipm_mapping
