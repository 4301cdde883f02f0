#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ipm_mapping/calibration_report.hpp"
#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/obstacles.hpp"

namespace ipm_mapping {

/// One raw camera frame with the robot's pose at its stamp.
struct Frame {
  std::uint64_t index = 0;
  double stamp = 0.0;  ///< seconds
  GrayView image;      ///< raw mono8; only valid during the call
  SE2 T_odom_base;
  Velocity velocity = {};    ///< at the stamp
  double time_offset = 0.0;  ///< seconds that the stamp was moved by because of timeOffset()
};

/// Why history begins anew.
enum class Restart : std::uint8_t {
  Missed,   ///< nobody listened for a while
  Clock,    ///< a clock was set back
  Odometry  ///< odometry jumped, or began at zero again
};

/// What a detector did with a frame. Everything but Used is a reason to count.
enum class FrameStatus : std::uint8_t {
  Used,               ///< the answer is valid
  Watched,            ///< the robot stands: the answer is valid, and no new evidence
  NoCamera,           ///< no usable calibration yet
  CameraUnsupported,  ///< the FPGA model's registers cannot hold the camera
  SizeMismatch,       ///< the image is not of the calibrated size
  NoReference,        ///< no earlier frame far enough back: the history is still filling
  NoMotion,           ///< the robot stands: no parallax, no answer
  TooMuchRotation,    ///< turning on the spot
  FocusUnusable,      ///< the beam has no usable focus
  GeometryUnusable    ///< the homography cannot be represented
};
inline constexpr int frame_status_count = 10;
[[nodiscard]] const char* name(FrameStatus status);
/// False for a valid answer, and where there is none because the robot's way shows nothing new.
[[nodiscard]] bool isFault(FrameStatus status);

/// Time spent in one named stage of the last frame.
struct StageTime {
  const char* stage;
  double seconds;
};

/// Frames and motion in, obstacles out. Implementations own their history and workspace, never
/// throw and do not allocate in process() after warm-up.
class Detector {
 public:
  virtual ~Detector() = default;

  /// New calibration or camera pose: forgets the history.
  virtual void setCamera(const CameraModel& camera, const CameraPose& T_base_camera) = 0;
  /// Goes on in the place of a detector with other parameters: with its camera, and with what it
  /// knows of the robot. False where there is nothing to take over; then setCamera() is due.
  virtual bool adopt(const Detector& /*before*/) { return false; }
  /// Forgets history and thresholds (clock or odometry jumped).
  virtual void reset() = 0;
  /// Fills `obstacles` when the answer is Used, or Watched, with an age above 0; leaves it empty
  /// otherwise.
  virtual FrameStatus process(const Frame& frame, Obstacles& obstacles) = 0;
  /// Stage times of the last processed frame, in order.
  [[nodiscard]] virtual const std::vector<StageTime>& stageTimes() const = 0;
  /// Short name, as in `detector: sweep`.
  [[nodiscard]] virtual const char* id() const = 0;
  /// How long after its stamp an image was taken, seconds, as far as that is to be worked with:
  /// later frames should come with stamps and poses that are moved by it.
  [[nodiscard]] virtual double timeOffset() const { return 0.0; }
  /// What self-calibration found so far; nothing from detectors without it.
  [[nodiscard]] virtual std::optional<CalibrationReport> calibration() const {
    return std::nullopt;
  }
};

}  // namespace ipm_mapping
