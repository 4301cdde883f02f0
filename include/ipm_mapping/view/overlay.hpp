#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/obstacles.hpp"

namespace ipm_mapping {

/// The undistorted view of a raw picture; black where the lens model does not reach.
[[nodiscard]] cv::Mat rectified(GrayView raw, const CameraModel& camera);

/// A detector's answer drawn over the camera picture it was made from, for people: free floor along
/// every bearing, contacts, bearings whose obstacle has its foot out of view, rings of equal
/// distance from the camera's foot, horizon and the beam's focus, and a caption. `raw` is the frame
/// as it came from the camera; `note` is added to the caption. Small pictures are enlarged. BGR.
[[nodiscard]] cv::Mat drawOverlay(GrayView raw, const Obstacles& obstacles,
                                  const std::string& note = "");

}  // namespace ipm_mapping
