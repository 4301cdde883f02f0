#include "ipm_mapping/ros/overlay_output.hpp"

#include <cv_bridge/cv_bridge.h>

#include <cmath>

#include "ipm_mapping/view/overlay.hpp"

namespace ipm_mapping {

void publishOverlay(const image_transport::Publisher& publisher, GrayView raw,
                    const Obstacles& obstacles, const std_msgs::Header& header) {
  if (publisher.getNumSubscribers() == 0) return;
  publisher.publish(cv_bridge::CvImage(header, "bgr8", drawOverlay(raw, obstacles)).toImageMsg());
}

CameraPictures::CameraPictures(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                               double image_time_offset)
    : image_time_offset_(image_time_offset),
      images_(node, private_node, "image_raw", static_cast<int>(kept),
              [this](const CameraMessage& message) {
                messages_.push_back(message);
                if (messages_.size() > kept) messages_.pop_front();
              }) {}

void CameraPictures::want(bool wanted) {
  if (wanted == wanted_) return;
  wanted_ = wanted;
  messages_.clear();
  wanted ? images_.start() : images_.stop();
}

bool CameraPictures::find(const ros::Time& stamp, GrayPicture& picture) const {
  for (const CameraMessage& message : messages_) {
    const double late = (stamp - message.header().stamp).toSec() - image_time_offset_;
    if (std::abs(late) < 1e-6) return !message.toGray(picture);
  }
  return false;
}

}  // namespace ipm_mapping
