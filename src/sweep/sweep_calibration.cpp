// Self-calibration inside the detector: learnt beside the frames, applied between them.
#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping::sweep {

void SweepDetector::learnCalibration() {
  if (calibration_mode_ == CalibrationMode::Off) return;
  calibration_.offer(current_, ring_);
  lap("self_calibration");
}

/// Rare: everything is compiled anew for the estimated pose, which allocates, and the history
/// begins anew. What was learnt stays.
void SweepDetector::applyCalibration() {
  if (calibration_mode_ != CalibrationMode::Apply || !calibration_.worthApplying()) return;
  const CalibrationVector state = calibration_.state();
  configure(corrected(T_base_stated_, state));
  calibration_.configure(grid_, rectification_.ranges(), state);
  ring_.clear();
}

/// Odometry's motion, without what is known to be wrong with it.
SE2 SweepDetector::expectedMotion(const RectifiedFrame& reference) const {
  const SE2 odometry = reference.T_odom_base.inverse() * current_.T_odom_base;
  if (calibration_mode_ != CalibrationMode::Apply || !calibration_.confident()) return odometry;
  return corrected(odometry, current_.stamp - reference.stamp, calibration_.state());
}

std::optional<CalibrationReport> SweepDetector::calibration() const {
  if (calibration_mode_ == CalibrationMode::Off) return std::nullopt;
  return calibration_.report();
}

}  // namespace ipm_mapping::sweep
