#include "ipm_mapping/ros/frame_source.hpp"

#include <cmath>
#include <utility>

#include "ipm_mapping/ros/camera_info.hpp"
#include "ipm_mapping/ros/frame_faults.hpp"
#include "ipm_mapping/ros/header_stamp.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

constexpr double silence = 10.0, repeat_silence = 60.0;  // seconds without any image
constexpr double start_seconds = 5.0;

}  // namespace

FrameSource::FrameSource(ros::NodeHandle& node, ros::NodeHandle& private_node,
                         const Parameters& parameters, StageMonitor& monitor, Handlers handlers)
    : camera_parameters_(parameters.camera),
      source_parameters_(loadStruct<SourceParameters>(private_node)),
      odometry_parameters_(parameters.odometry),
      monitor_(monitor),
      handlers_(std::move(handlers)),
      tf_listener_(tf_, node, false),
      camera_(node, tf_, parameters.camera, monitor),
      odometry_(node, tf_, source_parameters_,
                [this](double stamp, const SE2& pose) { onOdometry(stamp, pose); }),
      images_(node, private_node, "image_raw", source_parameters_.queue,
              [this](const CameraMessage& message) { onImage(message); }),
      gate_(parameters.odometry, static_cast<std::size_t>(source_parameters_.waiting_frames)) {
  tf_.setUsingDedicatedThread(true);
  monitor_.expect(images_.topic());
  // Frames that wait for tf or camera_info move on when it comes, not with the next image.
  pumper_ = node.createWallTimer(
      ros::WallDuration(0.2),
      [this](const ros::WallTimerEvent&) {
        pump();
        remindOfImages();
      },
      false, false);
}

void FrameSource::setParameters(const CameraParameters& parameters) {
  camera_parameters_ = parameters;
  camera_.setParameters(parameters);
  camera_revision_ = -1;
}

void FrameSource::start() {
  gate_ = Gate(odometry_parameters_, static_cast<std::size_t>(source_parameters_.waiting_frames));
  if (handlers_.time_offset) gate_.setTimeOffset(handlers_.time_offset());
  reported_drops_.fill(0);
  waiting_since_.reset();
  odometry_received_ = odometry_refused_ = 0;
  started_ = ros::WallTime::now();
  any_pose_ = false;
  handlers_.reset(Restart::Missed);
  odometry_.start();
  images_.start();
  pumper_.start();
}

void FrameSource::stop() {
  pumper_.stop();
  images_.stop();
  odometry_.stop();
}

/// Subscribed to images a moment before odometry: the first ones have no pose, and that is no
/// fault.
bool FrameSource::starting() const {
  return !any_pose_ && (ros::WallTime::now() - started_).toSec() < start_seconds;
}

/// A wrong topic is the commonest mistake, and a silent one.
void FrameSource::remindOfImages() {
  const ros::WallTime now = ros::WallTime::now();
  if (next_index_ > 0 || (now - started_).toSec() < silence || now < next_reminder_) return;
  next_reminder_ = now + ros::WallDuration(repeat_silence);
  const std::string other = images_.transportToTry();
  monitor_.warn("nothing comes in on " + images_.topic() +
                    (other.empty() ? "" : ": set image_transport to " + other),
                repeat_silence);
}

void FrameSource::restart(Restart cause, const char* why) {
  monitor_.count("resets");
  monitor_.warn(sentence(why, ", history starts anew"));
  handlers_.reset(cause);
}

void FrameSource::onImage(const CameraMessage& message) {
  monitor_.received();
  monitor_.lost(gaps_.missing(message.header().seq));
  optical_frame_ = withoutSlash(message.header().frame_id);
  const double stamp = stampOf(message.header()) + camera_parameters_.image_time_offset;
  if (std::isfinite(stamp)) newest_image_ = stamp;
  if (gate_.addFrame(stamp, {next_index_++, message}, now())) {
    waiting_since_.reset();
    restart(Restart::Clock, "clock of the images was set back");
  }
  pump();
}

void FrameSource::onOdometry(double stamp, const SE2& T_odom_base) {
  OdometryVerdict verdict = OdometryVerdict::Accepted;
  const bool anew = gate_.addOdometry(stamp, T_odom_base, now(), &verdict);
  if (verdict != OdometryVerdict::Accepted)
    monitor_.count(std::string("odometry_") + name(verdict));
  ++odometry_received_;
  if (verdict == OdometryVerdict::NotFinite || verdict == OdometryVerdict::Outlier) {
    ++odometry_refused_;
    refusal_ = verdict;
  }
  if (verdict == OdometryVerdict::NotFinite)
    monitor_.warn(sentence("odometry is dropped: ", explain(verdict)));
  if (anew) {
    waiting_since_.reset();
    if (verdict == OdometryVerdict::TimeJump)
      restart(Restart::Clock, "clock of the odometry was set back");
    else
      restart(Restart::Odometry, "odometry jumped");
  }
  pump();
}

bool FrameSource::patient() const {
  if (!waiting_since_) return true;
  const double patience = source_parameters_.patience;
  return newest_image_ - waiting_since_->stamp <= patience &&
         (ros::WallTime::now() - waiting_since_->arrival).toSec() <= patience;
}

bool FrameSource::cameraKnown() {
  // Without odometry the gate drops the frames by itself, and says so.
  if (gate_.waiting() == 0 || odometry_.frames().base.empty()) return true;
  if (camera_.update(optical_frame_, odometry_.frames().base, patient())) {
    waiting_since_.reset();
    return true;
  }
  if (!waiting_since_) waiting_since_ = {newest_image_, ros::WallTime::now()};
  return false;
}

double FrameSource::now() { return waiting_clock_.look(ros::SteadyTime::now().toSec()); }

void FrameSource::pump() {
  // Frames wait for a camera that may still become known; afterwards they are released to be
  // counted as lost.
  const bool release = cameraKnown() || !patient();
  Gate::Released frame;
  while (release && gate_.next(frame, now())) {
    reportGate();  // what was dropped before this frame, some of it before the first pose
    process(frame);
  }
  reportGate();
  if (const auto newest = gate_.odometry().newest(); newest && newest_image_ > 0.0)
    monitor_.set("odometry_behind_images_s", newest_image_ - *newest);
}

void FrameSource::process(const Gate::Released& frame) {
  any_pose_ = true;
  const CameraMessage& message = frame.payload.message;
  GrayPicture picture;
  if (const Refusal refusal = message.toGray(picture))
    return monitor_.dropped("bad_image", images_.topic() + ": " + *refusal);
  if (!camera_.update(optical_frame_, odometry_.frames().base, false))
    return monitor_.dropped(name(FrameStatus::NoCamera), camera_.complaint());
  if (const Refusal refusal = checkSize(camera_.model(), picture.view.width, picture.view.height))
    return monitor_.dropped(name(FrameStatus::SizeMismatch), images_.topic() + ": " + *refusal);
  if (camera_.revision() != camera_revision_) {
    camera_revision_ = camera_.revision();
    handlers_.camera(camera_.model(), camera_.T_base_camera());
  }
  FrameInfo info{message.header(), odometry_.frames(), message.header().stamp};
  if (camera_parameters_.image_time_offset != 0.0 || frame.time_offset != 0.0)
    info.header.stamp = rosTime(frame.stamp);
  const FrameStatus status = handlers_.frame({frame.payload.index, frame.stamp, picture.view,
                                              frame.T_odom_base, frame.velocity, frame.time_offset},
                                             info);
  if (handlers_.time_offset) gate_.setTimeOffset(handlers_.time_offset());
  monitor_.answered(status, info.header.stamp, explain(status));
}

/// Why no odometry reaches the images' stamps.
std::string FrameSource::missingOdometry() const {
  const std::string topic = odometry_.topic();
  if (odometry_received_ == 0)
    return source_parameters_.odometry_source == PoseOrigin::Tf
               ? sentence("tf has no poses of '", odometry_.frames().base, "' in '",
                          odometry_.frames().odom, "'")
               : "no odometry comes in on " + topic;
  if (2 * odometry_refused_ > odometry_received_)
    return sentence("odometry on ", topic, " is of no use: ", explain(refusal_));
  return explain(GateDrop::NoOdometry, topic);
}

void FrameSource::reportGate() {
  for (int i = 0; i < gate_drop_count; ++i) {
    const auto reason = static_cast<GateDrop>(i);
    std::uint64_t& reported = reported_drops_[static_cast<std::size_t>(i)];
    for (; reported < gate_.dropped(reason); ++reported) {
      if (reason == GateDrop::TooOld && starting()) {
        monitor_.skipped("before_odometry");
        continue;
      }
      monitor_.dropped(name(reason), reason == GateDrop::NoOdometry
                                         ? missingOdometry()
                                         : explain(reason, odometry_.topic()));
    }
  }
}

}  // namespace ipm_mapping
