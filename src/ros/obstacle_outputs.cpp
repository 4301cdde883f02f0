#include "ipm_mapping/ros/obstacle_outputs.hpp"

#include <boost/make_shared.hpp>

#include "ipm_mapping/ros/clouds.hpp"
#include "ipm_mapping/ros/scan.hpp"

namespace ipm_mapping {
namespace {

/// Publishes what `fill` writes, only where somebody listens.
template <class Message, class Fill>
void publishTo(const ros::Publisher& publisher, const std_msgs::Header& header, Fill&& fill) {
  if (publisher.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<Message>();
  message->header = header;
  fill(*message);
  publisher.publish(message);
}

}  // namespace

ObstacleOutputs::ObstacleOutputs(ros::NodeHandle& node, LazyOutputs& outputs,
                                 const OutputParameters& parameters)
    : parameters_(parameters),
      obstacles_(outputs.advertise<ObstacleArray>(node, "obstacles")),
      scan_(outputs.advertise<sensor_msgs::LaserScan>(node, "scan")),
      contacts_(outputs.advertise<sensor_msgs::PointCloud2>(node, "contacts")),
      free_(outputs.advertise<sensor_msgs::PointCloud2>(node, "free")) {}

void ObstacleOutputs::publish(const Obstacles& obstacles, const ros::Time& stamp,
                              const FrameNames& frames, const std::string& detector) const {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frames.base;
  publishTo<ObstacleArray>(obstacles_, header, [&](ObstacleArray& message) {
    toMessage(obstacles, frames, message);
    message.detector = detector;
  });
  publishTo<sensor_msgs::LaserScan>(scan_, header, [&](sensor_msgs::LaserScan& message) {
    toScan(obstacles, parameters_, message);
  });
  publishTo<sensor_msgs::PointCloud2>(contacts_, header, [&](sensor_msgs::PointCloud2& message) {
    toContactCloud(obstacles, parameters_, message);
  });
  publishTo<sensor_msgs::PointCloud2>(free_, header, [&](sensor_msgs::PointCloud2& message) {
    toFreeCloud(obstacles, parameters_, message);
  });
}

}  // namespace ipm_mapping
