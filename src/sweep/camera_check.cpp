#include "ipm_mapping/sweep/camera_check.hpp"

#include <algorithm>
#include <utility>

namespace ipm_mapping::sweep {
namespace {

constexpr double farthest_floor = 1.5;  // pixels

}  // namespace

CameraCheck::CameraCheck(const SweepParameters& sweep, const CalibrationParameters& calibration)
    : parameters_(sweep), calibration_(calibration, sweep.refinement) {}

void CameraCheck::setCamera(const CameraModel& camera, const CameraPose& T_base_camera) {
  if (!(camera == camera_)) {
    calibration_.forgetCamera();
    time_offset_ = 0.0;
  }
  camera_ = camera;
  T_base_camera_ = T_base_camera;
  const double range = effectiveMaxRange(camera, T_base_camera, parameters_.grid.max_range);
  grid_ = makePolarGrid(camera, T_base_camera, parameters_.grid, range);
  rectification_.configure(camera, T_base_camera, grid_);
  lattice_.configure(grid_, rectification_.ranges());
  ring_.configure(grid_, parameters_.reference);
  calibration_.setCamera(T_base_camera);
  calibration_.configure(rectification_, rectification_.ranges(), CalibrationVector::Zero());
  current_.image.resize(grid_.rows, grid_.lines);
  view_ = {};
  stated_errors_.clear();
  estimated_errors_.clear();
  reset();
}

void CameraCheck::reset() {
  ring_.clear();
  calibration_.reset();
  going_.reset();
}

std::optional<CalibrationReport> CameraCheck::calibration() const { return calibration_.report(); }

CameraPose CameraCheck::T_base_estimated() const {
  return corrected(T_base_camera_, calibration_.state());
}

FrameStatus CameraCheck::process(const Frame& frame, Obstacles& obstacles) {
  obstacles.clear();
  if (camera_.width() == 0) return FrameStatus::NoCamera;
  if (frame.image.width != camera_.width() || frame.image.height != camera_.height())
    return FrameStatus::SizeMismatch;
  if (grid_.lines == 0) return FrameStatus::GeometryUnusable;
  rectification_.rectify(frame.image, current_.image.view());
  current_.mean.evaluate(lattice_, current_.image.view());
  current_.T_odom_base = frame.T_odom_base;
  current_.velocity = frame.velocity;
  current_.stamp = frame.stamp;
  current_.time_offset = frame.time_offset;
  current_.went = going_.add(current_, frame.stamp);
  // A short drive may end before the estimate is confident: it has its picture all the same.
  const bool first_look = view_.picture.empty();
  if (calibration_.offer(current_, ring_) && (calibration_.confident() || first_look))
    measure(frame.image);
  ring_.offer(current_);
  if (calibration_.timeOffsetDiffers(time_offset_)) time_offset_ = calibration_.timeOffset();
  return FrameStatus::NoReference;
}

/// What is left between the frames of the last pair when the state is this and nothing else.
std::vector<PatchShift> CameraCheck::shiftsWith(const CalibrationVector& state) {
  const FramePair pair{current_, *calibration_.lastReference()};
  const PairEvidence alignment =
      calibration_.floor().evaluate(pair, CalibrationInformation::certainly(state), state);
  return floorRegistration(pair, calibration_.floor(), alignment, camera_, T_base_camera_);
}

/// Patches that the estimate brings home are floor; the others stand on it.
void CameraCheck::measure(GrayView raw) {
  std::vector<PatchShift> stated, estimated;
  const std::vector<PatchShift> all_stated = shiftsWith(CalibrationVector::Zero());
  for (const PatchShift& after : shiftsWith(calibration_.state())) {
    if (after.shift.norm() > farthest_floor) continue;
    for (const PatchShift& before : all_stated) {
      if (before.pixel != after.pixel) continue;
      stated.push_back(before);
      estimated.push_back(after);
      stated_errors_.push_back(before.shift.norm());
      estimated_errors_.push_back(after.shift.norm());
    }
  }
  if (!view_.picture.empty() && estimated.size() <= view_.estimated.size()) return;
  view_.picture.ensure(raw.width, raw.height);
  for (int v = 0; v < raw.height; ++v) std::copy_n(raw.row(v), raw.width, view_.picture.row(v));
  view_.stated = std::move(stated);
  view_.estimated = std::move(estimated);
}

}  // namespace ipm_mapping::sweep
