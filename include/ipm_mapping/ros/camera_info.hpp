#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <string>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/ros/images.hpp"

namespace ipm_mapping {

/// Calibration of the pictures that the driver publishes: K cut down to the region of interest and
/// scaled by the binning. Binned pixels are averages, so centres at integer coordinates move by
/// half a pixel: c' = (c - offset + 0.5) / b - 0.5.
/// Refused by name: K[0] = 0, fisheye and other lens models, a region outside the sensor.
[[nodiscard]] Refusal toCamera(const sensor_msgs::CameraInfo& info, CameraModel& camera);

/// Names both sizes when an image is not of the calibrated size.
[[nodiscard]] Refusal checkSize(const CameraModel& camera, int width, int height);

/// The YAML file that camera_calibration writes (image_width, image_height, camera_matrix,
/// distortion_model, distortion_coefficients), or a CameraInfo as rostopic prints it (width,
/// height, K, D).
[[nodiscard]] Refusal readCalibrationFile(const std::string& path, sensor_msgs::CameraInfo& info);

}  // namespace ipm_mapping
