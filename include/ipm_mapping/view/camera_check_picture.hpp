#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/floor_registration.hpp"

namespace ipm_mapping {

/// One of the two poses in the picture: where it puts horizon and floor, and what is left between
/// two frames of the floor with it.
struct CheckedPose {
  CameraPose T_base_camera = CameraPose::Identity();
  std::vector<sweep::PatchShift> shifts;
  std::string words;  ///< for the key
};

/// The undistorted camera picture with horizon, floor grid (half a metre) and what is left between
/// two frames, patch by patch, ten times as long as it is: for the stated and the estimated pose.
/// `raw` is the frame as it came from the camera; `facts` is the caption's first line. BGR.
[[nodiscard]] cv::Mat drawCameraCheck(GrayView raw, const CameraModel& camera,
                                      const CheckedPose& stated, const CheckedPose& estimated,
                                      const std::string& facts);

}  // namespace ipm_mapping
