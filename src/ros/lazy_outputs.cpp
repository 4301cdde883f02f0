#include "ipm_mapping/ros/lazy_outputs.hpp"

#include <boost/make_shared.hpp>

#include "ipm_mapping/ros/images.hpp"
#include "ipm_mapping/ros/wiring.hpp"

namespace ipm_mapping {

void LazyOutputs::update() {
  bool wanted = always_;
  for (const auto& each : publishers_) wanted = wanted || each.getNumSubscribers() > 0;
  for (const auto& each : pictures_) wanted = wanted || each.getNumSubscribers() > 0;
  if (wanted == awake_) return;
  awake_ = wanted;
  const auto lock = wiringLock();
  change_(wanted);
}

void publishPicture(const image_transport::Publisher& publisher, GrayView picture,
                    const std_msgs::Header& header) {
  if (publisher.getNumSubscribers() == 0) return;
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header = header;
  copyMono8(picture, *message);
  publisher.publish(message);
}

}  // namespace ipm_mapping
