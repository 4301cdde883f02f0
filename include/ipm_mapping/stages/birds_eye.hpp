#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// Bird's-eye view of the obstacle mask (the source, §3.5, §6.3): a virtual camera of the same K
/// and size looks straight down from over the mid foot point, the robot's forward axis upwards.
struct BirdsEye {
  /// Takes output pixels (U, V, 1) to undistorted input pixels up to the (positive) depth: the
  /// inverse direction of eq. 3.35, whose plane equation 3.31 has to equal 1, not 0.
  Eigen::Matrix3d to_input = Eigen::Matrix3d::Identity();
  /// Third row of to_input is the depth already: positive in front of the camera.
  double metres_per_pixel = 0.0;
  Eigen::Vector2d mid_foot{0, 0};  ///< in base, metres: at output pixel (cx, cy)

  /// `span`: metres that the width of the output covers.
  static BirdsEye over(const GroundView& view, double span);

  /// Floor point, in base, of an output pixel.
  [[nodiscard]] Eigen::Vector2d floor(const Intrinsics& k, double U, double V) const {
    return {mid_foot.x() - (V - k.cy) * metres_per_pixel,
            mid_foot.y() - (U - k.cx) * metres_per_pixel};
  }
};

/// Samples the mask at the nearest pixel; mask::unseen where the camera does not look.
void birdsEyeView(const BirdsEye& birds_eye, GrayView obstacle_mask, GrayBuffer out);

}  // namespace ipm_mapping
