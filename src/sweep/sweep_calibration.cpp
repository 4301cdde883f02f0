// Self-calibration inside the detector: learnt beside the frames, applied between them.
#include <algorithm>
#include <cmath>

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
  rectifyWith(calibration_.state());
  ring_.clear();
}

void SweepDetector::rectifyWith(const CalibrationVector& correction) {
  configure(corrected(T_base_stated_, correction));
  calibration_.configure(rectification_, shutter_.rows(), correction);
}

/// What the view has to spare at its edges; in steps, so that it is rarely compiled anew.
double SweepDetector::longestReadout() const {
  constexpr double step = 0.015;
  return step * std::ceil(std::abs(readout_) / step);
}

/// A readout time changes nothing about where things are said to be: it is always put into force.
void SweepDetector::applyReadout() {
  if (learn_readout_ && calibration_.readoutDiffers(readout_)) workWith(calibration_.readout());
}

/// Frames of before keep what was undone in them, and lose what the view no longer shows; room that
/// was made is kept.
void SweepDetector::workWith(double readout) {
  readout_ = readout;
  if (longestReadout() <= shutter_.longest()) return;
  configureView();
  shutter_.blankOutside(current_.image);
  ring_.forEach([this](RectifiedFrame& frame) { shutter_.blankOutside(frame.image); });
  calibration_.configure(rectification_, shutter_.rows(), calibration_.inForce());
}

/// What stands below the view is remembered by the floor's own motion, which therefore goes on.
bool SweepDetector::adopt(const Detector& before) {
  const auto* other = dynamic_cast<const SweepDetector*>(&before);
  if (other == nullptr || other->camera_.width() == 0) return false;
  setCamera(other->camera_, other->T_base_stated_);
  const CalibrationVector& in_force = other->calibration_.inForce();
  const bool known = calibration_.adopt(other->calibration_);
  if (known && calibration_mode_ == CalibrationMode::Apply && !in_force.isZero())
    rectifyWith(in_force);
  if (known && learn_readout_) workWith(other->readout_);
  const double most = calibration_.mostTimeOffset();
  if (known && learn_time_offset_) time_offset_ = std::clamp(other->time_offset_, -most, most);
  if (known && learn_shading_) {
    shading_.adopt(other->shading_);
    shadeWith(other->rectification_.shading());
  }
  free_floor_.adopt(other->free_floor_);
  stood_ = stood_before_ = other->stood_;  // its clock
  last_ = other->last_;
  T_floor_last_ = other->T_floor_last_;
  chain_offset_ = other->chain_offset_;
  return true;
}

/// Nor does a lens that darkens: references are brought up to date.
void SweepDetector::applyShading() {
  if (learn_shading_ && shading_.differs(rectification_.shading())) shadeWith(shading_.estimate());
}

void SweepDetector::shadeWith(double shading) {
  const double before = rectification_.shading();
  rectification_.setShading(shading);
  ring_.forEach([&](RectifiedFrame& frame) {
    if (frame.image.height() != grid_.lines) return;  // has not been used yet
    rectification_.shadeAgain(before, frame.image.view());
    frame.mean.evaluate(lattice_, frame.image.view());
  });
}

/// What stamps are off changes nothing about where the camera is: whoever brings the frames is
/// always told.
void SweepDetector::applyTimeOffset() {
  if (!learn_time_offset_) return;
  const bool forgotten = calibration_.pairs() == 0 && calibration_.timeOffset() == 0.0;
  if (forgotten || calibration_.timeOffsetDiffers(time_offset_))
    time_offset_ = calibration_.timeOffset();
}

/// Floor poses that were chained up with other stamps lead elsewhere, and the search for the next
/// motion begins with them: odometry with the right ones is better. While the robot stands that is
/// put off, for what was free is known in them too.
void SweepDetector::chainAnew() {
  chain_offset_ = current_.time_offset;
  ring_.forEach([this](RectifiedFrame& frame) {
    frame.T_floor_base = current_.T_floor_base * odometryBetween(frame, current_).inverse();
  });
  moving_.reset();
}

/// Odometry's motion, without what is known to be wrong with it.
SE2 SweepDetector::expectedMotion(const RectifiedFrame& reference) const {
  const SE2 odometry = odometryBetween(reference, current_);
  if (calibration_mode_ != CalibrationMode::Apply || !calibration_.confident()) return odometry;
  return corrected(odometry, FramePair{current_, reference}.seconds(), calibration_.state());
}

std::optional<CalibrationReport> SweepDetector::calibration() const {
  if (calibration_mode_ == CalibrationMode::Off) return std::nullopt;
  CalibrationReport report = calibration_.report();
  report.shading = {shading_stated_, shading_.estimate(), shading_.sigma()};
  return report;
}

}  // namespace ipm_mapping::sweep
