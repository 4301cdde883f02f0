#pragma once

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/sweep/floor_odometry.hpp"

namespace ipm_mapping {

/// What a detector's last frame says about the robot's way: wheel odometry, and the motion on the
/// floor where the detector refines one. Points into the detector until its next frame.
[[nodiscard]] sweep::FloorObservation floorObservation(const Detector& detector, const Frame& frame,
                                                       FrameStatus status);

}  // namespace ipm_mapping
