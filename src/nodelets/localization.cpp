#include <ipm_mapping/ObstacleMask.h>

#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>
#include <vector>

#include "ipm_mapping/detectors/birds_eye_localization.hpp"
#include "ipm_mapping/detectors/localization.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/live_parameters.hpp"
#include "ipm_mapping/ros/obstacle_outputs.hpp"
#include "ipm_mapping/ros/overlay_output.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"

namespace ipm_mapping {

/// Obstacle mask in, obstacles out, as message, scan and clouds: third link of either architecture.
class LocatorNodelet : public StageNodelet {
 protected:
  /// `id`: of the detector that the whole chain is.
  LocatorNodelet(const char* id, std::vector<std::string> groups)
      : id_(id), groups_(std::move(groups)) {}

 private:
  [[nodiscard]] virtual std::unique_ptr<Locator> makeLocator(
      const Parameters& parameters) const = 0;

  void start() override {
    const Parameters parameters = loadParameters(privateNode());
    locator_ = makeLocator(parameters);
    queue_ = static_cast<std::uint32_t>(loadStruct<StageParameters>(privateNode()).queue);
    monitor().expect(node().resolveName("mask"));
    monitor().setAsleep(true);
    obstacle_outputs_.emplace(node(), outputs_, parameters.output);
    overlay_ = outputs_.advertiseImage(node(), "overlay");
    pictures_.emplace(node(), privateNode());
    live_.emplace(privateNode(), parameters, groups_, [this](const Parameters& changed) {
      locator_ = makeLocator(changed);
      obstacle_outputs_->setParameters(changed.output);
    });
  }

  void setAwake(bool awake) {
    monitor().setAsleep(!awake);
    if (awake)
      mask_ = node().subscribe("mask", queue_, &LocatorNodelet::onMask, this,
                               ros::TransportHints().tcpNoDelay());
    else
      mask_.shutdown();
  }

  void onMask(const ObstacleMaskConstPtr& input) {
    monitor().received();
    guarded([&] { process(*input); });
  }

  void process(const ObstacleMask& input) {
    GrayView mask;
    Refusal refusal = wrap(input, mask);
    if (!refusal) refusal = fromMessage(input.view, input.header.stamp, view_);
    if (refusal) return monitor().dropped("bad_image", *refusal);
    obstacles_.clear();
    obstacles_.frame = input.frame;
    obstacles_.threshold = input.threshold;
    obstacles_.separability = input.separability;
    const FrameStatus status = locator_->process(view_, mask, obstacles_);
    if (status == FrameStatus::Used) publish(input);
    monitor().set("contacts", static_cast<double>(obstacles_.contacts.size()));
    monitor().answered(status, input.header.stamp, "the view of this mask has no usable beam");
  }

  void publish(const ObstacleMask& input) {
    obstacle_outputs_->publish(obstacles_, input.header.stamp,
                               {input.view.base_frame, input.view.odom_frame}, id_);
    pictures_->want(overlay_.getNumSubscribers() > 0);
    GrayPicture picture;
    if (overlay_.getNumSubscribers() > 0 && pictures_->find(input.image_stamp, picture))
      publishOverlay(overlay_, picture.view, obstacles_, input.header);
  }

  const char* id_;
  std::vector<std::string> groups_;
  std::unique_ptr<Locator> locator_;
  GroundView view_;
  Obstacles obstacles_;
  std::uint32_t queue_ = 1;
  LazyOutputs outputs_{[this](bool awake) { setAwake(awake); }};
  std::optional<ObstacleOutputs> obstacle_outputs_;
  std::optional<CameraPictures> pictures_;
  std::optional<LiveParameters> live_;
  image_transport::Publisher overlay_;
  ros::Subscriber mask_;
};

/// Contacts where the mask's triangles stand (the source, chapter 5).
class LocalizationNodelet : public LocatorNodelet {
 public:
  LocalizationNodelet() : LocatorNodelet("chain", {"localization", "output"}) {}

 private:
  [[nodiscard]] std::unique_ptr<Locator> makeLocator(const Parameters& parameters) const override {
    return std::make_unique<Localization>(parameters.localization);
  }
};

/// Contacts from the mask seen from above: the first architecture (the source, §3.5-3.8).
class BirdsEyeLocalizationNodelet : public LocatorNodelet {
 public:
  BirdsEyeLocalizationNodelet()
      : LocatorNodelet("first_architecture", {"birds_eye", "localization", "output"}) {}

 private:
  [[nodiscard]] std::unique_ptr<Locator> makeLocator(const Parameters& parameters) const override {
    return std::make_unique<BirdsEyeLocalization>(parameters.birds_eye, parameters.localization);
  }
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::LocalizationNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(ipm_mapping::BirdsEyeLocalizationNodelet, nodelet::Nodelet)
