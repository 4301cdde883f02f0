#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/chain_map.hpp"
#include "ipm_mapping/kernels/chain_sample.hpp"

namespace ipm_mapping {

/// Undistortion fused with the warp through the floor's homography (the source, §6.2.2; the lens is
/// applied after the homography, not before it as printed).
///
/// Both pictures live on the grid of the undistorted current view: the current frame is sampled at
/// distort(p), the reference frame at distort(G p), bilinearly. Coordinates are rounded to 1/128 px
/// (worst error against the exact composed map below 0.02 px), grey levels to the nearest integer
/// within 1/32. A picture of one row or one column has nothing to interpolate: nothing is valid.
class UndistortWarp {
 public:
  UndistortWarp() = default;
  /// Compiles the fixed map of the current view.
  explicit UndistortWarp(const CameraModel& camera);

  /// raw: W x H. undistorted: W x H grey levels, 0 where the lens maps outside the picture;
  /// valid: 255 or 0.
  void undistort(GrayView raw, GrayBuffer undistorted, GrayBuffer valid);

  /// raw_reference: W x H. warped: W x H; valid is ANDed: stays only where the sample lies inside
  /// the reference picture and the floor is below the horizon in both views.
  void warp(GrayView raw_reference, const GroundView& view, GrayBuffer warped, GrayBuffer valid);

 private:
  CameraModel camera_;
  kernels::Lens lens_{};
  kernels::Samples fixed_;  ///< of the current view, all rows
  kernels::Samples row_;    ///< of the reference view, one row
  std::array<kernels::KeyRow, 3> keys_;
  std::vector<std::uint16_t> scratch_;
};

}  // namespace ipm_mapping
