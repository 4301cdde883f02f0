#pragma once

#include <optional>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/floor_registration.hpp"
#include "ipm_mapping/sweep/self_calibration.hpp"

namespace ipm_mapping::sweep {

/// Registration of the floor between two frames, with the pose as stated and as estimated.
struct RegistrationView {
  Image<std::uint8_t> picture;  ///< raw
  std::vector<PatchShift> stated, estimated;
};

/// Self-calibration on its own, and how well the floor fits before and after: frames in, an
/// estimate out, no obstacles. For people and tools: frames that measure allocate.
class CameraCheck : public Detector {
 public:
  CameraCheck(const SweepParameters& sweep, const CalibrationParameters& calibration);
  CameraCheck(const CameraCheck&) = delete;  // its parts know one another
  CameraCheck& operator=(const CameraCheck&) = delete;

  void setCamera(const CameraModel& camera, const CameraPose& T_base_camera) override;
  void reset() override;
  /// NoReference where all is well: there are no obstacles to tell of.
  FrameStatus process(const Frame& frame, Obstacles& obstacles) override;
  [[nodiscard]] const std::vector<StageTime>& stageTimes() const override { return times_; }
  [[nodiscard]] const char* id() const override { return "camera_check"; }
  [[nodiscard]] double timeOffset() const override { return time_offset_; }
  [[nodiscard]] std::optional<CalibrationReport> calibration() const override;

  [[nodiscard]] const CameraModel& camera() const { return camera_; }
  [[nodiscard]] const CameraPose& T_base_stated() const { return T_base_camera_; }
  [[nodiscard]] CameraPose T_base_estimated() const;
  [[nodiscard]] const SelfCalibration& learnt() const { return calibration_; }
  /// The frame whose floor was measured best; without a picture if there was none.
  [[nodiscard]] const RegistrationView& view() const { return view_; }
  /// Lengths of all shifts of all frames, raw pixels.
  [[nodiscard]] const std::vector<double>& statedErrors() const { return stated_errors_; }
  [[nodiscard]] const std::vector<double>& estimatedErrors() const { return estimated_errors_; }

 private:
  void measure(GrayView raw);
  std::vector<PatchShift> shiftsWith(const CalibrationVector& state);

  SweepParameters parameters_;
  CameraModel camera_;
  CameraPose T_base_camera_ = CameraPose::Identity();
  PolarGrid grid_;
  CylindricalRectification rectification_;
  BlockLattice lattice_;
  ReferenceRing ring_;
  SelfCalibration calibration_;
  RectifiedFrame current_;
  GoingClock going_;
  double time_offset_ = 0.0;  ///< that frames should come with, seconds
  RegistrationView view_;
  std::vector<double> stated_errors_, estimated_errors_;
  std::vector<StageTime> times_;
};

}  // namespace ipm_mapping::sweep
