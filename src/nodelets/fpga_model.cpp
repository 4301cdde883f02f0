#include <ipm_mapping/DifferenceImage.h>
#include <ipm_mapping/ObstacleMask.h>

#include <boost/make_shared.hpp>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "ipm_mapping/ros/fpga_messages.hpp"
#include "ipm_mapping/ros/frame_source.hpp"
#include "ipm_mapping/ros/live_parameters.hpp"
#include "ipm_mapping/ros/obstacle_outputs.hpp"
#include "ipm_mapping/ros/overlay_output.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"

namespace ipm_mapping {

/// Camera and odometry in, every wire of the bit-true FPGA model out, below `fpga/`.
class FpgaModel : public StageNodelet {
  void start() override {
    parameters_ = loadParameters(privateNode());
    model_.emplace(parameters_);
    source_.emplace(
        node(), privateNode(), parameters_, monitor(),
        FrameSource::Handlers{
            [this](const CameraModel& camera, const CameraPose& T_base_camera) {
              setCamera(camera, T_base_camera);
            },
            [this](Restart) { model_->reset(); },
            [this](const Frame& frame, const FrameInfo& info) { return process(frame, info); }});
    monitor().setAsleep(true);
    advertise();
    live_.emplace(privateNode(), parameters_,
                  std::vector<std::string>{"fpga", "fpga_clock", "reference", "localization",
                                           "camera", "output"},
                  [this](const Parameters& changed) { change(changed); });
  }

  void advertise() {
    ros::NodeHandle below(node(), "fpga");
    obstacle_outputs_.emplace(below, outputs_, parameters_.output);
    difference_ = outputs_.advertise<DifferenceImage>(below, "difference");
    mask_ = outputs_.advertise<ObstacleMask>(below, "mask");
    report_ = outputs_.advertise<FpgaReport>(below, "report");
    difference_image_ = outputs_.advertiseImage(below, "difference/image");
    mask_image_ = outputs_.advertiseImage(below, "mask/image");
    overlay_ = outputs_.advertiseImage(below, "overlay");
  }

  void setAwake(bool awake) {
    monitor().setAsleep(!awake);
    guarded([&] { awake ? source_->start() : source_->stop(); });
  }

  void setCamera(const CameraModel& camera, const CameraPose& T_base_camera) {
    model_->setCamera(camera, T_base_camera);
    if (model_->cameraError())
      monitor().warn("the registers cannot hold this camera: " + *model_->cameraError());
    if (fpga::SoftwarePart::ignoresTangential(camera))
      monitor().warn("the datapath has no tangential distortion: p1 and p2 are ignored");
  }

  void change(const Parameters& changed) {
    parameters_ = changed;
    obstacle_outputs_->setParameters(changed.output);
    model_.emplace(changed);
    source_->setParameters(changed.camera);
  }

  FrameStatus process(const Frame& frame, const FrameInfo& info) {
    model_->keepDifference(difference_.getNumSubscribers() > 0 ||
                           difference_image_.getNumSubscribers() > 0);
    const FrameStatus status = model_->process(frame, obstacles_);
    if (status != FrameStatus::Used) return status;
    obstacle_outputs_->publish(obstacles_, info.header.stamp, info.frames, model_->id());
    publishDifference(info);
    publishMask(info);
    publishReport(info.header);
    publishOverlay(overlay_, frame.image, obstacles_, info.header);
    monitor().set("contacts", static_cast<double>(obstacles_.contacts.size()));
    monitor().set("threshold", obstacles_.threshold);
    monitor().set("homography_error_px", model_->frameSetup().homography_error);
    return status;
  }

  void publishDifference(const FrameInfo& info) {
    const auto wire = model_->difference();
    if (wire.empty()) return;
    auto message = boost::make_shared<DifferenceImage>();
    message->header = message->image.header = message->valid.header = info.header;
    message->frame = obstacles_.frame;
    message->image_stamp = info.image_stamp;
    toMessage(obstacles_.view, info.frames, message->view);
    const GrayBuffer grey = allocateMono8(wire.width, wire.height, message->image);
    splitTagged(wire, grey, allocateMono8(wire.width, wire.height, message->valid));
    difference_.publish(message);
    publishPicture(difference_image_, grey, info.header);
  }

  void publishMask(const FrameInfo& info) {
    publishPicture(mask_image_, model_->mask(), info.header);
    if (mask_.getNumSubscribers() == 0) return;
    auto message = boost::make_shared<ObstacleMask>();
    message->header = message->mask.header = info.header;
    message->frame = obstacles_.frame;
    message->image_stamp = info.image_stamp;
    message->threshold = static_cast<std::int16_t>(obstacles_.threshold);
    message->separability = obstacles_.separability;
    toMessage(obstacles_.view, info.frames, message->view);
    copyMono8(model_->mask(), message->mask);
    mask_.publish(message);
  }

  void publishReport(const std_msgs::Header& header) {
    if (report_.getNumSubscribers() == 0) return;
    auto message = boost::make_shared<FpgaReport>();
    message->header = header;
    message->frame = obstacles_.frame;
    toMessage(*model_, parameters_.fpga_clock, *message);
    report_.publish(message);
  }

  Parameters parameters_;
  std::optional<FpgaDetector> model_;
  Obstacles obstacles_;
  std::optional<FrameSource> source_;
  LazyOutputs outputs_{[this](bool awake) { setAwake(awake); }};
  std::optional<ObstacleOutputs> obstacle_outputs_;
  std::optional<LiveParameters> live_;
  ros::Publisher difference_, mask_, report_;
  image_transport::Publisher difference_image_, mask_image_, overlay_;
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::FpgaModel, nodelet::Nodelet)
