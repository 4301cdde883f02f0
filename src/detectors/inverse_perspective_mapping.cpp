#include "ipm_mapping/detectors/inverse_perspective_mapping.hpp"

#include "ipm_mapping/detectors/reference_status.hpp"
#include "ipm_mapping/stages/difference.hpp"

namespace ipm_mapping {
InversePerspectiveMapping::InversePerspectiveMapping(const ReferenceParameters& parameters)
    : references_(parameters) {}

void InversePerspectiveMapping::setCamera(const CameraModel& camera,
                                          const CameraPose& T_base_camera) {
  if (!(has_camera_ && camera == camera_)) {
    warp_ = UndistortWarp(camera);
    rectified_.resize(camera.width(), camera.height());
    warped_.resize(camera.width(), camera.height());
  }
  camera_ = camera;
  T_base_camera_ = T_base_camera;
  has_camera_ = true;
  reset();
}

void InversePerspectiveMapping::reset() {
  references_.clear();
  reference_ = nullptr;
  frame_ = Frame{};
}

FrameStatus InversePerspectiveMapping::select(const Frame& frame, GroundView& view) {
  reference_ = nullptr;
  frame_ = Frame{};
  if (!has_camera_) return FrameStatus::NoCamera;
  if (frame.image.width != camera_.width() || frame.image.height != camera_.height())
    return FrameStatus::SizeMismatch;
  frame_ = frame;
  const ReferenceSelector::Choice choice = references_.choose(frame.stamp, frame.T_odom_base);
  if (choice.verdict != ReferenceVerdict::Chosen) return frameStatus(choice.verdict);
  reference_ = choice.reference;
  view = {frame.stamp,    reference_->stamp, camera_,
          T_base_camera_, frame.T_odom_base, choice.motion};
  view_ = view;
  return FrameStatus::Used;
}

void InversePerspectiveMapping::difference(GrayBuffer difference, GrayBuffer valid) {
  if (reference_ == nullptr) return;
  warp_.undistort(frame_.image, rectified_.view(), valid);
  warp_.warp(reference_->image.view(), view_, warped_.view(), valid);
  absoluteDifference(warped_.view(), rectified_.view(), valid, difference);
}

void InversePerspectiveMapping::remember() {
  if (!frame_.image.empty()) references_.remember(frame_.stamp, frame_.T_odom_base, frame_.image);
  frame_ = Frame{};  // the picture is the caller's: valid until here
}

}  // namespace ipm_mapping
