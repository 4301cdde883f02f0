#include "ipm_mapping/ros/image_subscriber.hpp"

#include <algorithm>
#include <utility>

#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"

namespace ipm_mapping {

ImageSubscriber::ImageSubscriber(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                                 const std::string& topic, int queue, Handler handler)
    : node_(node),
      private_node_(private_node),
      base_(node.resolveName(topic)),
      transport_(loadStruct<TransportParameters>(private_node).image_transport),
      topic_(transport_ == "raw" ? base_ : base_ + "/" + transport_),
      queue_(static_cast<std::uint32_t>(queue)),
      handler_(std::move(handler)),
      image_transport_(node) {}

void ImageSubscriber::start() {
  if (transport_ == "compressed" && !startTransport()) return startDecoding();
  if (transport_ != "compressed" && !startTransport())
    throw std::runtime_error("image_transport '" + transport_ +
                             "' is not installed; raw and compressed always work");
}

bool ImageSubscriber::startTransport() {
  const auto declared = image_transport_.getLoadableTransports();
  const std::string plugin = "image_transport/" + transport_;
  if (std::find(declared.begin(), declared.end(), plugin) == declared.end()) return false;
  through_transport_ = image_transport_.subscribe(
      base_, queue_,
      [this](const sensor_msgs::ImageConstPtr& image) {
        handler_({image, nullptr});
      },
      ros::VoidPtr(),
      image_transport::TransportHints(transport_, ros::TransportHints().tcpNoDelay(),
                                      private_node_));
  return true;
}

void ImageSubscriber::startDecoding() {
  decoded_here_ = node_.subscribe<sensor_msgs::CompressedImage>(
      topic_, queue_, [this](const sensor_msgs::CompressedImageConstPtr& image) {
        handler_({nullptr, image});
      });
}

std::string ImageSubscriber::transportToTry() const {
  ros::master::V_TopicInfo published;
  if (!ros::master::getTopics(published)) return "";
  for (const std::string transport : {"compressed", "raw"}) {
    const std::string topic = transport == "raw" ? base_ : base_ + "/" + transport;
    if (topic == topic_) continue;
    for (const ros::master::TopicInfo& info : published)
      if (info.name == topic) return transport;
  }
  return "";
}

void ImageSubscriber::stop() {
  through_transport_.shutdown();
  decoded_here_.shutdown();
}

}  // namespace ipm_mapping
