#include "ipm_mapping/geometry/camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

namespace ipm_mapping {
namespace {

double derivativeOfRadial(const Distortion& d, double q) {
  return 1.0 + q * (3.0 * d.k1 + q * (5.0 * d.k2 + q * 7.0 * d.k3));
}

/// Smallest positive root q of 1 + 3 k1 q + 5 k2 q^2 + 7 k3 q^3, infinity where there is none. The
/// cubic is monotonic between the roots of its derivative: the first such stretch on which it falls
/// to 0 holds the root.
double firstTurningPoint(const Distortion& d) {
  constexpr double far = 1e9;
  std::vector<double> ends;
  const double a = 21.0 * d.k3, b = 10.0 * d.k2, c = 3.0 * d.k1;
  const double discriminant = b * b - 4.0 * a * c;
  if (a != 0.0 && discriminant >= 0.0) {
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    ends.push_back(q / a);
    if (q != 0.0) ends.push_back(c / q);
  } else if (a == 0.0 && b != 0.0) {
    ends.push_back(-c / b);
  }
  ends.push_back(far);
  std::sort(ends.begin(), ends.end());
  double low = 0.0;
  for (const double end : ends) {
    if (!(end > low)) continue;
    if (derivativeOfRadial(d, end) > 0.0) {
      low = end;
      continue;
    }
    double high = end;
    for (double middle = 0.5 * (low + high); middle > low && middle < high;
         middle = 0.5 * (low + high))
      (derivativeOfRadial(d, middle) > 0.0 ? low : high) = middle;
    return high;
  }
  return std::numeric_limits<double>::infinity();
}

template <class... Parts>
std::string sentence(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

bool usableFocalLength(double f) { return std::isfinite(f) && f > 0.0; }

}  // namespace

CameraModel::CameraModel(const Intrinsics& intrinsics, const Distortion& distortion)
    : intrinsics_(intrinsics),
      distortion_(distortion),
      turning_radius_squared_(firstTurningPoint(distortion)) {}

std::optional<CalibrationError> CameraModel::check(const Intrinsics& k, const std::string& model,
                                                   const std::vector<double>& D) {
  if (k.width <= 0 || k.height <= 0)
    return sentence("image size ", k.width, "x", k.height, " is not a size");
  if (!usableFocalLength(k.fx) || !usableFocalLength(k.fy))
    return sentence("K[0] = ", k.fx, ", K[4] = ", k.fy, ": the camera is not calibrated");
  if (!std::isfinite(k.cx) || !std::isfinite(k.cy))
    return sentence("principal point (", k.cx, ", ", k.cy, ") is not finite");
  if (!(model.empty() || model == "plumb_bob"))
    return sentence("distortion model '", model, "' is not supported, only 'plumb_bob'");
  if (D.size() > 5) return sentence("D has ", D.size(), " coefficients, plumb_bob has at most 5");
  if (!std::all_of(D.begin(), D.end(), [](double c) { return std::isfinite(c); }))
    return std::string("D has a coefficient that is not finite");
  return std::nullopt;
}

Distortion CameraModel::distortionFrom(const std::vector<double>& D) {
  std::array<double, 5> c{};
  std::copy_n(D.begin(), std::min<std::size_t>(D.size(), c.size()), c.begin());
  return {c[0], c[1], c[2], c[3], c[4]};
}

bool CameraModel::undistortPixel(double u_raw, double v_raw, double& u, double& v) const {
  const Intrinsics& k = intrinsics_;
  const double x_raw = (u_raw - k.cx) / k.fx, y_raw = (v_raw - k.cy) / k.fy;
  double x = x_raw, y = y_raw;
  for (int i = 0; i < 100; ++i) {
    double u_now = 0.0, v_now = 0.0;
    if (!distortNormalized(x, y, u_now, v_now)) return false;
    const double dx = (u_raw - u_now) / k.fx, dy = (v_raw - v_now) / k.fy;
    x += dx;
    y += dy;
    if (std::abs(dx) + std::abs(dy) < 1e-9) {
      u = k.fx * x + k.cx;
      v = k.fy * y + k.cy;
      return true;
    }
  }
  return false;
}

CameraPose cameraPose(double x, double y, double z, double pitch, double yaw, double roll) {
  Eigen::Matrix3d
      optical_in_level;  // columns: right, down, forward of a level camera, in base axes
  optical_in_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  CameraPose pose = CameraPose::Identity();
  pose.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix() *
                  optical_in_level * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

double pitchOf(const CameraPose& T_base_camera) {
  return std::asin(std::clamp(-T_base_camera.linear()(2, 2), -1.0, 1.0));
}

}  // namespace ipm_mapping
