#include "ipm_mapping_sim/lens.hpp"

#include <Eigen/LU>
#include <cmath>

namespace ipm_mapping::sim {

CameraModel cameraModel(const CameraSpec& camera) {
  const Intrinsics intrinsics{camera.width, camera.height, camera.fx,
                              camera.fy,    camera.cx,     camera.cy};
  if (const auto error = CameraModel::check(intrinsics, "plumb_bob", camera.distortion)) {
    throw ParameterError("scene: camera: " + *error);
  }
  return {intrinsics, CameraModel::distortionFrom(camera.distortion)};
}

CameraPose statedPose(const CameraSpec& camera) {
  return cameraPose(camera.x, camera.y, camera.z, camera.pitch);
}

CameraPose truePose(const CameraSpec& camera) {
  return cameraPose(camera.x, camera.y, camera.z + camera.height_error,
                    camera.pitch + camera.pitch_error);
}

bool Lens::undistort(const CameraModel& model, double u, double v, Eigen::Vector2d& point) {
  const Intrinsics& k = model.intrinsics();
  const Eigen::Vector2d wanted(u, v);
  const auto project = [&](const Eigen::Vector2d& p, Eigen::Vector2d& out) {
    return model.distortNormalized(p.x(), p.y(), out.x(), out.y());
  };
  // From the middle outwards, so that a start beyond the turning radius cannot happen.
  Eigen::Vector2d p(0.0, 0.0), at, right, down;
  for (int i = 0; i < 50; ++i) {
    constexpr double step = 1e-6;
    if (!project(p, at)) return false;
    const Eigen::Vector2d error = wanted - at;
    if (error.norm() < 1e-7) break;
    if (!project(p + Eigen::Vector2d(step, 0), right)) return false;
    if (!project(p + Eigen::Vector2d(0, step), down)) return false;
    Eigen::Matrix2d slope;
    slope << (right - at) / step, (down - at) / step;
    Eigen::Vector2d change = slope.inverse() * error;
    const double limit = 100.0 / k.fx;
    if (change.norm() > limit) change *= limit / change.norm();
    p += change;
  }
  point = p;
  return project(p, at) && (wanted - at).norm() < 1e-4;
}

Lens::Lens(const CameraModel& model) : width_(model.width()), height_(model.height()) {
  pixels_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const auto ray = [&](double u, double v, Eigen::Vector2f& out) {
    Eigen::Vector2d point;
    const bool seen = undistort(model, u, v, point);
    if (seen) out = point.cast<float>();
    return seen;
  };
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      Pixel& p = pixels_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(u)];
      p.seen = ray(u, v, p.at);
      p.dx = Eigen::Vector2f(1.0F / static_cast<float>(model.intrinsics().fx), 0.0F);
      p.dy = Eigen::Vector2f(0.0F, 1.0F / static_cast<float>(model.intrinsics().fy));
    }
  }
  for (int v = 1; v + 1 < height_; ++v) {
    for (int u = 1; u + 1 < width_; ++u) {
      const auto at = [&](int i, int j) -> const Pixel& { return pixel(i, j); };
      Pixel& p = pixels_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(u)];
      if (!at(u - 1, v).seen || !at(u + 1, v).seen || !at(u, v - 1).seen || !at(u, v + 1).seen) {
        continue;
      }
      p.dx = 0.5F * (at(u + 1, v).at - at(u - 1, v).at);
      p.dy = 0.5F * (at(u, v + 1).at - at(u, v - 1).at);
    }
  }
}

}  // namespace ipm_mapping::sim
