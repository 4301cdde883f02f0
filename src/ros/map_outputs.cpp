#include "ipm_mapping/ros/map_outputs.hpp"

#include <map_msgs/OccupancyGridUpdate.h>
#include <ros/single_subscriber_publisher.h>

#include <boost/make_shared.hpp>
#include <cmath>

namespace ipm_mapping {
namespace {

/// Side of the unknown map that stands in while nothing was seen, cells.
constexpr int empty_side = 64;

}  // namespace

MapOutputs::MapOutputs(ros::NodeHandle& node, OccupancyMap& map, const MapperParameters& parameters)
    : map_(map), full_map_period_(parameters.full_map_period) {
  header_.frame_id = parameters.frame;
  const auto advertise = [&](const char* topic, Values values) {
    return node.advertise<nav_msgs::OccupancyGrid>(
        topic, 1,
        [this, values](const ros::SingleSubscriberPublisher& newcomer) { greet(newcomer, values); },
        ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true);
  };
  map_publisher_ = advertise("map", Values::Trinary);
  probability_publisher_ = advertise("map_probability", Values::Probability);
  updates_publisher_ = node.advertise<map_msgs::OccupancyGridUpdate>("map_updates", 10);
}

void MapOutputs::setHeader(const std::string& frame, const ros::Time& stamp) {
  header_.frame_id = frame;
  header_.stamp = stamp;
}

nav_msgs::OccupancyGridPtr MapOutputs::grid(Values values) const {
  const MapGeometry& geometry = map_.geometry();
  const bool empty = geometry.empty();
  auto message = boost::make_shared<nav_msgs::OccupancyGrid>();
  message->header = header_;
  message->info.map_load_time = header_.stamp;
  message->info.resolution = static_cast<float>(geometry.resolution);
  message->info.width = static_cast<std::uint32_t>(empty ? empty_side : geometry.width);
  message->info.height = static_cast<std::uint32_t>(empty ? empty_side : geometry.height);
  const auto centred = [&](double place) {
    return geometry.resolution * (std::floor(place / geometry.resolution) - 0.5 * empty_side);
  };
  message->info.origin.position.x = empty ? centred(robot_.x()) : geometry.originX();
  message->info.origin.position.y = empty ? centred(robot_.y()) : geometry.originY();
  message->info.origin.orientation.w = 1.0;
  message->data.assign(std::size_t{message->info.width} * message->info.height, -1);
  for (std::size_t i = 0; !empty && i < message->data.size(); ++i)
    message->data[i] = values == Values::Trinary ? map_.occupancy(i) : map_.probability(i);
  return message;
}

void MapOutputs::greet(const ros::SingleSubscriberPublisher& newcomer, Values values) const {
  if (stale_ || values == Values::Probability) newcomer.publish(grid(values));
}

void MapOutputs::publishAll() {
  map_publisher_.publish(grid(Values::Trinary));
  if (probability_publisher_.getNumSubscribers() > 0)
    probability_publisher_.publish(grid(Values::Probability));
  (void)map_.takeChanges();
  published_revision_ = map_.geometry().revision;
  stale_ = false;
  last_full_map_ = ros::WallTime::now();
}

void MapOutputs::publishChanges() {
  const bool due = (ros::WallTime::now() - last_full_map_).toSec() >= full_map_period_;
  if (map_.geometry().revision != published_revision_) return publishAll();
  if (const auto changed = map_.takeChanges()) {
    publishUpdate(*changed);
    stale_ = true;
  }
  if (stale_ && due) publishAll();
}

void MapOutputs::publishUpdate(const MapRectangle& changed) {
  if (updates_publisher_.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<map_msgs::OccupancyGridUpdate>();
  message->header = header_;
  message->x = changed.x;
  message->y = changed.y;
  message->width = static_cast<std::uint32_t>(changed.width);
  message->height = static_cast<std::uint32_t>(changed.height);
  message->data.reserve(std::size_t{message->width} * message->height);
  const auto row = static_cast<std::size_t>(map_.geometry().width);
  for (int y = changed.y; y < changed.y + changed.height; ++y)
    for (int x = changed.x; x < changed.x + changed.width; ++x)
      message->data.push_back(
          map_.occupancy(static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x)));
  updates_publisher_.publish(message);
}

}  // namespace ipm_mapping
