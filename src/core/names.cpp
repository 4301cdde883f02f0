#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/frame_gate.hpp"

namespace ipm_mapping {

const char* name(BearingState state) {
  switch (state) {
    case BearingState::Unknown:
      return "unknown";
    case BearingState::Free:
      return "free";
    case BearingState::Occupied:
      return "occupied";
    case BearingState::Blocked:
      return "blocked";
  }
  return "unknown";
}

const char* name(FrameStatus status) {
  switch (status) {
    case FrameStatus::Used:
      return "used";
    case FrameStatus::Watched:
      return "watched";
    case FrameStatus::NoCamera:
      return "no_camera";
    case FrameStatus::CameraUnsupported:
      return "camera_unsupported";
    case FrameStatus::SizeMismatch:
      return "size_mismatch";
    case FrameStatus::NoReference:
      return "no_reference";
    case FrameStatus::NoMotion:
      return "no_motion";
    case FrameStatus::TooMuchRotation:
      return "too_much_rotation";
    case FrameStatus::FocusUnusable:
      return "focus_unusable";
    case FrameStatus::GeometryUnusable:
      return "geometry_unusable";
  }
  return "unknown";
}

bool isFault(FrameStatus status) {
  switch (status) {
    case FrameStatus::Used:
    case FrameStatus::Watched:
    case FrameStatus::NoReference:
    case FrameStatus::NoMotion:
    case FrameStatus::TooMuchRotation:
      return false;
    default:
      return true;
  }
}

const char* name(GateDrop reason) {
  switch (reason) {
    case GateDrop::Overflow:
      return "queue_overflow";
    case GateDrop::NoOdometry:
      return "no_odometry";
    case GateDrop::TooOld:
      return "older_than_odometry";
    case GateDrop::OdometryGap:
      return "odometry_gap";
    case GateDrop::OutOfOrder:
      return "out_of_order";
    case GateDrop::BadStamp:
      return "bad_stamp";
    case GateDrop::ClockJump:
      return "clock_jump";
  }
  return "unknown";
}

}  // namespace ipm_mapping
