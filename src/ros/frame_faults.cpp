#include "ipm_mapping/ros/frame_faults.hpp"

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/ros/offline_run.hpp"
#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

/// "reason (count), reason (count)".
class CountedReasons {
 public:
  void add(const std::string& reason, std::uint64_t count) {
    if (count == 0) return;
    total_ += count;
    words_ += sentence(words_.empty() ? "" : ", ", reason, " (", count, ")");
  }
  [[nodiscard]] const std::string& words() const { return words_; }
  [[nodiscard]] std::uint64_t total() const { return total_; }

 private:
  std::string words_;
  std::uint64_t total_ = 0;
};

void addAnswers(const RunReport& report, bool faults, CountedReasons& reasons) {
  for (int i = 0; i < frame_status_count; ++i) {
    const auto status = static_cast<FrameStatus>(i);
    if (status != FrameStatus::Used && isFault(status) == faults)
      reasons.add(explain(status), report.frames[static_cast<std::size_t>(i)]);
  }
}

CountedReasons faultsOf(const RunReport& report, const BagTopics& topics) {
  CountedReasons faults;
  if (report.unusable_images > 0) faults.add(report.first_refusal, report.unusable_images);
  for (int i = 0; i < gate_drop_count; ++i)
    faults.add(explain(static_cast<GateDrop>(i), topics.odometry),
               report.gate_drops[static_cast<std::size_t>(i)]);
  addAnswers(report, true, faults);
  return faults;
}

std::string odometryFaults(const RunReport& report, const BagTopics& topics) {
  CountedReasons faults;
  for (const OdometryVerdict refusal : {OdometryVerdict::NotFinite, OdometryVerdict::Outlier})
    if (const auto found = report.odometry.find(name(refusal)); found != report.odometry.end())
      faults.add(explain(refusal), found->second);
  return faults.total() == 0 ? ""
                             : "; refused messages on " + topics.odometry + ": " + faults.words();
}

}  // namespace

std::string explain(GateDrop reason, const std::string& odometry) {
  switch (reason) {
    case GateDrop::Overflow:
      return "too many images wait for odometry on " + odometry;
    case GateDrop::NoOdometry:
      return "odometry on " + odometry + " does not reach the images' stamps";
    case GateDrop::TooOld:
      return "image older than all odometry on " + odometry;
    case GateDrop::OdometryGap:
      return "gap in the odometry on " + odometry;
    case GateDrop::OutOfOrder:
      return "image is not newer than the one before it";
    case GateDrop::BadStamp:
      return "image without a stamp: its header.stamp is 0";
    case GateDrop::ClockJump:
      return "image still waited for odometry when the clock was set back";
  }
  return "image dropped";
}

const char* explain(OdometryVerdict refusal) {
  return refusal == OdometryVerdict::NotFinite
             ? "not finite, without a stamp, or with an orientation that is no unit quaternion"
             : "jumps farther than odometry/max_speed and odometry/max_jump allow";
}

std::string explain(FrameStatus status) {
  switch (status) {
    case FrameStatus::Used:
      return "used";
    case FrameStatus::Watched:
      return "the robot stands and looks on";
    case FrameStatus::NoCamera:
      return "the camera's calibration is not known";
    case FrameStatus::CameraUnsupported:
      return sentence("the FPGA model holds images up to ", fpga::max_width, " x ",
                      fpga::max_height, " of cameras that fit its registers: not this one");
    case FrameStatus::SizeMismatch:
      return "image is not of the calibrated size";
    case FrameStatus::NoReference:
      return "no earlier image from far enough back";
    case FrameStatus::NoMotion:
      return "the robot stands";
    case FrameStatus::TooMuchRotation:
      return "the robot turns on the spot";
    case FrameStatus::FocusUnusable:
      return "the beam has no usable focus";
    case FrameStatus::GeometryUnusable:
      return "the geometry of this frame cannot be used";
  }
  return "no answer";
}

std::string dropConcern(const RunReport& report, const BagTopics& topics) {
  const CountedReasons reasons = faultsOf(report, topics);
  if (reasons.total() == 0) return "";
  return sentence(reasons.total(), " of ", report.images, " frames dropped: ", reasons.words(),
                  odometryFaults(report, topics));
}

std::string frameConcern(const RunReport& report, const BagTopics& topics) {
  if (report.used() > 0) return dropConcern(report, topics);
  CountedReasons reasons = faultsOf(report, topics);
  addAnswers(report, false, reasons);
  return sentence("none of ", report.images, " frames used: ", reasons.words(),
                  odometryFaults(report, topics));
}

}  // namespace ipm_mapping
