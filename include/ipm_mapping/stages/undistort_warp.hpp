#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// Undistortion fused with the warp through the floor's homography (the source, §6.2.2; the lens is
/// applied after the homography, not before it as printed).
///
/// Both pictures live on the grid of the undistorted current view: the current frame is sampled at
/// distort(p), the reference frame at distort(G p), bilinearly. Coordinates are rounded to 1/256 px
/// (worst error against the exact composed map below 0.02 px), grey levels to the nearest integer.
class UndistortWarp {
 public:
  UndistortWarp() = default;
  /// Compiles the fixed map of the current view.
  explicit UndistortWarp(const CameraModel& camera);

  /// raw: W x H. undistorted: W x H grey levels, 0 where the lens maps outside the picture;
  /// valid: 255 or 0.
  void undistort(GrayView raw, GrayBuffer undistorted, GrayBuffer valid) const;

  /// raw_reference: W x H. warped: W x H; valid is ANDed: stays 255 only where the sample lies
  /// inside the reference picture and the floor is below the horizon in both views.
  void warp(GrayView raw_reference, const GroundView& view, GrayBuffer warped, GrayBuffer valid);

  /// Raw reference coordinates of the undistorted current pixel (u, v), exactly; false where not
  /// valid. The slow definition of what warp() samples.
  struct Map {
    const CameraModel* camera;
    Eigen::Matrix3d to_normalized;  ///< K^-1 G
    Eigen::RowVector3d horizon;     ///< row 3 of the current view's H^-1: inverse depth
    [[nodiscard]] bool exact(double u, double v, double& u_raw, double& v_raw) const;
  };
  [[nodiscard]] static Map map(const GroundView& view);

 private:
  /// One key row of the map: exact raw coordinates for every column.
  struct KeyRow {
    std::vector<float> u, v;
    std::vector<std::uint8_t> valid;
  };
  void fillKeyRow(const Map& map, int v, KeyRow& key) const;
  void interpolateRow(const Map& map, int v, float t, const KeyRow& above, const KeyRow& below);
  void sampleRow(GrayView raw, std::uint8_t* out, std::uint8_t* valid) const;

  CameraModel camera_;
  struct FixedSample {
    std::int32_t offset;       ///< v * W + u of the upper left pixel, -1: not valid
    std::uint16_t fraction_u;  ///< 1/256 px, 0..256
    std::uint16_t fraction_v;
  };
  std::vector<FixedSample> fixed_;
  KeyRow above_, below_;
  std::vector<std::int32_t> row_u_, row_v_;  ///< 24.8 raw coordinates of one row; -1: not valid
};

}  // namespace ipm_mapping
