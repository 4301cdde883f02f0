#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace ipm_mapping {

/// Pinhole intrinsics in pixels, pixel centres at integer coordinates (the source, eq. 3.2).
struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;

  [[nodiscard]] Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d k;
    k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
    return k;
  }
  [[nodiscard]] bool operator==(const Intrinsics& o) const {
    return width == o.width && height == o.height && fx == o.fx && fy == o.fy && cx == o.cx &&
           cy == o.cy;
  }
};

/// Brown-Conrady coefficients in the order of sensor_msgs/CameraInfo: k1 k2 p1 p2 k3 (`plumb_bob`).
struct Distortion {
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0;

  [[nodiscard]] bool none() const {
    return k1 == 0.0 && k2 == 0.0 && p1 == 0.0 && p2 == 0.0 && k3 == 0.0;
  }
  [[nodiscard]] bool operator==(const Distortion& o) const {
    return k1 == o.k1 && k2 == o.k2 && p1 == o.p1 && p2 == o.p2 && k3 == o.k3;
  }
};

/// Why a calibration cannot be used; the text names the offending field and its value.
using CalibrationError = std::string;

/// Intrinsics and lens of one camera: from undistorted to raw pixels (the source, §3.2.3, §6.2.2).
class CameraModel {
 public:
  CameraModel() = default;
  CameraModel(const Intrinsics& intrinsics, const Distortion& distortion);

  /// Checks what a driver or a calibration file says: nothing when it can be used, otherwise one
  /// sentence that names the field. `model` is CameraInfo's distortion_model.
  [[nodiscard]] static std::optional<CalibrationError> check(const Intrinsics& intrinsics,
                                                             const std::string& model,
                                                             const std::vector<double>& D);
  /// Coefficients in plumb_bob order from a CameraInfo's D that passed check(); missing ones are 0.
  [[nodiscard]] static Distortion distortionFrom(const std::vector<double>& D);

  [[nodiscard]] const Intrinsics& intrinsics() const { return intrinsics_; }
  [[nodiscard]] const Distortion& distortion() const { return distortion_; }
  [[nodiscard]] int width() const { return intrinsics_.width; }
  [[nodiscard]] int height() const { return intrinsics_.height; }

  /// Squared normalised radius at which r(1 + k1 r^2 + k2 r^4 + k3 r^6) turns over: beyond it the
  /// polynomial folds points far outside the view back into the image. Infinity where it never
  /// does.
  [[nodiscard]] double turningRadiusSquared() const { return turning_radius_squared_; }

  /// Normalised undistorted (x/z, y/z) to raw pixel; false beyond the turning radius.
  [[nodiscard]] bool distortNormalized(double x, double y, double& u_raw, double& v_raw) const {
    const double xx = x * x, yy = y * y, xy = x * y, r2 = xx + yy;
    if (!(r2 < turning_radius_squared_)) return false;
    const Distortion& d = distortion_;
    const double radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
    u_raw =
        intrinsics_.fx * (x * radial + 2.0 * d.p1 * xy + d.p2 * (r2 + 2.0 * xx)) + intrinsics_.cx;
    v_raw =
        intrinsics_.fy * (y * radial + d.p1 * (r2 + 2.0 * yy) + 2.0 * d.p2 * xy) + intrinsics_.cy;
    return true;
  }
  /// Undistorted pixel to raw pixel; false beyond the turning radius.
  [[nodiscard]] bool distortPixel(double u, double v, double& u_raw, double& v_raw) const {
    return distortNormalized((u - intrinsics_.cx) / intrinsics_.fx,
                             (v - intrinsics_.cy) / intrinsics_.fy, u_raw, v_raw);
  }

  /// Raw pixel to undistorted pixel, by fixed-point iteration to 1e-9; false where it does not
  /// converge (outside the image of the lens).
  bool undistortPixel(double u_raw, double v_raw, double& u, double& v) const;

  [[nodiscard]] bool operator==(const CameraModel& o) const {
    return intrinsics_ == o.intrinsics_ && distortion_ == o.distortion_;
  }

 private:
  Intrinsics intrinsics_;
  Distortion distortion_;
  double turning_radius_squared_ = 0.0;
};

/// Camera pose on the robot: takes optical coordinates to base coordinates.
using CameraPose = Eigen::Isometry3d;

/// Pose of a camera at (x, y, z) metres in base that looks forward, pitched down by `pitch` and
/// turned left by `yaw`, rolled by `roll` about its optical axis (radians).
[[nodiscard]] CameraPose cameraPose(double x, double y, double z, double pitch, double yaw = 0.0,
                                    double roll = 0.0);

/// Depression of the optical axis below the horizontal, radians.
[[nodiscard]] double pitchOf(const CameraPose& T_base_camera);

}  // namespace ipm_mapping
