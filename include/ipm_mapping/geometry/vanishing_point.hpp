#pragma once

#include <Eigen/Core>
#include <optional>

#include "ipm_mapping/geometry/ground_view.hpp"

namespace ipm_mapping {

/// Where the beam of the polar histogram starts, homogeneous: f = f_xy / f_w in pixels when
/// f_w != 0, a direction when f_w = 0 (level camera). The line through pixel p has the direction
/// f_xy - f_w p; for f_w < 0 the focus lies behind and the beam diverges downwards.
struct Focus {
  Eigen::Vector3d f = Eigen::Vector3d(0, 1, 0);

  /// Direction of the beam at a pixel, towards the foot of a vertical line.
  [[nodiscard]] Eigen::Vector2d direction(double u, double v) const {
    return {f.x() - f.z() * u, f.y() - f.z() * v};
  }
  /// The focus as a pixel; nothing where it lies at infinity.
  [[nodiscard]] std::optional<Eigen::Vector2d> pixel() const {
    if (f.z() == 0.0) return std::nullopt;
    return Eigen::Vector2d(f.head<2>() / f.z());
  }
};

/// Both vertical vanishing points in the current image, scales kept: f1 = H_c c_c of the current
/// camera's foot (eq. 5.5: K d), f2 = H_c c_r of the reference camera's foot. Vertical edges of the
/// current image point to f1, those of the warped reference image to f2.
struct VanishingPoints {
  Eigen::Vector3d f1;
  Eigen::Vector3d f2;
};
[[nodiscard]] VanishingPoints vanishingPoints(const GroundView& view);

/// f1 + f2: the image of the mid foot point.
[[nodiscard]] Focus midFootFocus(const VanishingPoints& points);

/// Eq. 6.9, the mean of the two *pixels*, where both feet are in front of the camera (w > 0);
/// the mid foot point elsewhere.
[[nodiscard]] Focus meanPixelFocus(const VanishingPoints& points);

}  // namespace ipm_mapping
