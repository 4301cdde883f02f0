#include <ipm_mapping/DifferenceImage.h>
#include <ipm_mapping/ObstacleMask.h>

#include <boost/make_shared.hpp>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "ipm_mapping/detectors/segmentation.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/lazy_outputs.hpp"
#include "ipm_mapping/ros/live_parameters.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"
#include "ipm_mapping/ros/stamp_order.hpp"

namespace ipm_mapping {

/// Difference image in, obstacle mask out (the source, §3.4).
class SegmentationNodelet : public StageNodelet {
  void start() override {
    const Parameters parameters = loadParameters(privateNode());
    segmentation_.emplace(parameters.segmentation);
    live_.emplace(
        privateNode(), parameters, std::vector<std::string>{"segmentation"},
        [this](const Parameters& changed) { segmentation_->setParameters(changed.segmentation); });
    queue_ = static_cast<std::uint32_t>(loadStruct<StageParameters>(privateNode()).queue);
    monitor().expect(node().resolveName("difference"));
    monitor().setAsleep(true);
    mask_ = outputs_.advertise<ObstacleMask>(node(), "mask");
    mask_image_ = outputs_.advertiseImage(node(), "mask/image");
    blurred_ = outputs_.advertiseImage(node(), "blurred");
  }

  void setAwake(bool awake) {
    monitor().setAsleep(!awake);
    segmentation_->reset();
    order_.forget();
    if (awake)
      difference_ = node().subscribe("difference", queue_, &SegmentationNodelet::onDifference, this,
                                     ros::TransportHints().tcpNoDelay());
    else
      difference_.shutdown();
  }

  void onDifference(const DifferenceImageConstPtr& input) {
    monitor().received();
    const StampVerdict verdict = order_.judge(input->header.stamp);
    if (verdict == StampVerdict::Late)
      return monitor().dropped("out_of_order", "difference image is older than the one before it");
    if (verdict == StampVerdict::Jump) {
      monitor().count("resets");
      segmentation_->reset();
    }
    guarded([&] { process(*input); });
  }

  void process(const DifferenceImage& input) {
    GrayView difference, valid;
    if (const Refusal refusal = wrap(input, difference, valid))
      return monitor().dropped("bad_image", *refusal);
    auto message = boost::make_shared<ObstacleMask>();
    message->header = message->mask.header = input.header;
    message->frame = input.frame;
    message->image_stamp = input.image_stamp;
    message->view = input.view;
    const auto result = segmentation_->process(
        difference, valid, allocateMono8(difference.width, difference.height, message->mask));
    message->threshold = static_cast<std::int16_t>(result.threshold);
    message->separability = result.separability;
    monitor().set("threshold", result.threshold);
    monitor().set("separability", result.separability);
    mask_.publish(message);
    GrayView mask;
    if (!wrap(*message, mask)) publishPicture(mask_image_, mask, input.header);
    publishPicture(blurred_, segmentation_->blurred(), input.header);
    monitor().used(input.header.stamp);
  }

  std::optional<Segmentation> segmentation_;
  StampOrder order_;
  std::uint32_t queue_ = 1;
  LazyOutputs outputs_{[this](bool awake) { setAwake(awake); }};
  std::optional<LiveParameters> live_;
  ros::Publisher mask_;
  image_transport::Publisher mask_image_, blurred_;
  ros::Subscriber difference_;
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::SegmentationNodelet, nodelet::Nodelet)
