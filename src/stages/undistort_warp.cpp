#include "ipm_mapping/stages/undistort_warp.hpp"

#include <algorithm>

namespace ipm_mapping {
namespace {

kernels::Lens lensOf(const CameraModel& camera) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const Intrinsics& k = camera.intrinsics();
  const Distortion& d = camera.distortion();
  return {f(k.fx), f(k.fy), f(k.cx), f(k.cy), f(d.k1),
          f(d.k2), f(d.p1), f(d.p2), f(d.k3), f(camera.turningRadiusSquared()),
          k.width, k.height};
}

/// Current pixels as rays of the reference camera.
///
/// G keeps the scale in which its third component is the ratio of both depths, so its sign tells
/// whether the point is in front of the reference camera once it is in front of the current one.
class Rays {
 public:
  explicit Rays(const GroundView& view)
      : to_normalized_(view.camera.intrinsics().matrix().inverse() * view.G()),
        inverse_depth_(view.currentFloor().inverse().row(2)) {}

  [[nodiscard]] kernels::RayRow row(int v) const {
    const Eigen::Vector3f start = (to_normalized_ * Eigen::Vector3d(0, v, 1)).cast<float>();
    const Eigen::Vector3f step = to_normalized_.col(0).cast<float>();
    const double inverse_depth = inverse_depth_.y() * v + inverse_depth_.z();
    return {start.x(), start.y(), start.z(), static_cast<float>(inverse_depth),
            step.x(),  step.y(),  step.z(),  static_cast<float>(inverse_depth_.x())};
  }

 private:
  Eigen::Matrix3d to_normalized_;  ///< K^-1 G
  Eigen::RowVector3d inverse_depth_;
};

void clear(GrayBuffer picture, GrayBuffer valid) {
  for (int v = 0; v < picture.height; ++v) {
    std::fill_n(picture.row(v), picture.width, std::uint8_t{0});
    std::fill_n(valid.row(v), valid.width, std::uint8_t{0});
  }
}

}  // namespace

UndistortWarp::UndistortWarp(const CameraModel& camera) : camera_(camera), lens_(lensOf(camera)) {
  const int W = camera.width(), H = camera.height();
  fixed_.resize(W, H);
  row_.resize(W, 1);
  scratch_.resize(2 * static_cast<std::size_t>(row_.paddedWidth()));
  if (W < 2 || H < 2) return;
  for (int v = 0; v < H; ++v) {
    for (int u = 0; u < W; ++u) {
      double u_raw = 0, v_raw = 0;
      if (camera.distortPixel(u, v, u_raw, v_raw))
        kernels::Samples::put(fixed_.row(v), u, u_raw, v_raw, W, H);
    }
  }
}

void UndistortWarp::undistort(GrayView raw, GrayBuffer undistorted, GrayBuffer valid) {
  if (raw.width < 2 || raw.height < 2) return clear(undistorted, valid);
  for (int v = 0; v < raw.height; ++v)
    kernels::sampleRow(raw, fixed_.row(v), raw.width, kernels::Validity::Set, scratch_.data(),
                       undistorted.row(v), valid.row(v));
}

void UndistortWarp::warp(GrayView raw_reference, const GroundView& view, GrayBuffer warped,
                         GrayBuffer valid) {
  if (raw_reference.width < 2 || raw_reference.height < 2) return clear(warped, valid);
  const Rays rays(view);
  for (int v = 0; v < raw_reference.height; ++v) {
    kernels::mapRow(rays.row(v), lens_, row_.row(0), row_.paddedWidth());
    kernels::sampleRow(raw_reference, row_.row(0), raw_reference.width, kernels::Validity::And,
                       scratch_.data(), warped.row(v), valid.row(v));
  }
}

}  // namespace ipm_mapping
