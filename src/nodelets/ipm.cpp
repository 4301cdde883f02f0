#include <ipm_mapping/DifferenceImage.h>

#include <boost/make_shared.hpp>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "ipm_mapping/detectors/inverse_perspective_mapping.hpp"
#include "ipm_mapping/ros/frame_source.hpp"
#include "ipm_mapping/ros/lazy_outputs.hpp"
#include "ipm_mapping/ros/live_parameters.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"

namespace ipm_mapping {

/// Camera and odometry in, difference image out (the source, §3.3).
class Ipm : public StageNodelet {
  void start() override {
    const Parameters parameters = loadParameters(privateNode());
    ipm_.emplace(parameters.reference);
    source_.emplace(
        node(), privateNode(), parameters, monitor(),
        FrameSource::Handlers{
            [this](const CameraModel& camera, const CameraPose& T_base_camera) {
              ipm_->setCamera(camera, T_base_camera);
            },
            [this](Restart) { ipm_->reset(); },
            [this](const Frame& frame, const FrameInfo& info) { return process(frame, info); }});
    monitor().setAsleep(true);
    live_.emplace(privateNode(), parameters, std::vector<std::string>{"reference", "camera"},
                  [this](const Parameters& changed) {
                    ipm_.emplace(changed.reference);
                    source_->setParameters(changed.camera);
                  });
    difference_ = outputs_.advertise<DifferenceImage>(node(), "difference");
    difference_image_ = outputs_.advertiseImage(node(), "difference/image");
    rectified_ = outputs_.advertiseImage(node(), "image_rect");
    warped_ = outputs_.advertiseImage(node(), "warped");
  }

  void setAwake(bool awake) {
    monitor().setAsleep(!awake);
    guarded([&] { awake ? source_->start() : source_->stop(); });
  }

  FrameStatus process(const Frame& frame, const FrameInfo& info) {
    auto message = boost::make_shared<DifferenceImage>();
    GroundView view;
    const FrameStatus status = ipm_->select(frame, view);
    if (status == FrameStatus::Used) {
      message->header = message->image.header = message->valid.header = info.header;
      message->frame = frame.index;
      message->image_stamp = info.image_stamp;
      toMessage(view, info.frames, message->view);
      const int width = frame.image.width, height = frame.image.height;
      ipm_->difference(allocateMono8(width, height, message->image),
                       allocateMono8(width, height, message->valid));
      publishPicture(rectified_, ipm_->rectified(), info.header);
      publishPicture(warped_, ipm_->warped(), info.header);
      difference_.publish(message);
      GrayView difference;
      if (!wrapMono8(message->image, difference))
        publishPicture(difference_image_, difference, info.header);
    }
    ipm_->remember();
    return status;
  }

  std::optional<InversePerspectiveMapping> ipm_;
  std::optional<FrameSource> source_;
  LazyOutputs outputs_{[this](bool awake) { setAwake(awake); }};
  std::optional<LiveParameters> live_;
  ros::Publisher difference_;
  image_transport::Publisher difference_image_, rectified_, warped_;
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::Ipm, nodelet::Nodelet)
