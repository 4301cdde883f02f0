#include "ipm_mapping/ros/overlay_output.hpp"

#include <cv_bridge/cv_bridge.h>

#include "ipm_mapping/view/overlay.hpp"

namespace ipm_mapping {

void publishOverlay(const image_transport::Publisher& publisher, GrayView raw,
                    const Obstacles& obstacles, const std_msgs::Header& header) {
  if (publisher.getNumSubscribers() == 0) return;
  publisher.publish(cv_bridge::CvImage(header, "bgr8", drawOverlay(raw, obstacles)).toImageMsg());
}

CameraPictures::CameraPictures(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : images_(node, private_node, "image_raw", static_cast<int>(kept),
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

bool CameraPictures::find(const ros::Time& image_stamp, GrayPicture& picture) const {
  for (const CameraMessage& message : messages_)
    if (message.header().stamp == image_stamp) return !message.toGray(picture);
  return false;
}

}  // namespace ipm_mapping
