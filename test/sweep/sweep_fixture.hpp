#pragma once

#include <random>

#include "ipm_mapping/sweep/sweep_detector.hpp"
#include "support/ray_scene.hpp"

namespace ipm_mapping::test {

/// A small camera that looks down on the floor: fast to render, same geometry.
inline CameraModel smallCamera(const Distortion& lens = {0.05, -0.1, 0.001, -0.001, 0.01}) {
  return CameraModel(Intrinsics{400, 300, 328.0, 328.0, 199.5, 149.5}, lens);
}
inline CameraPose smallCameraPose(double pitch = 0.42) {
  return cameraPose(0.05, -0.01, 0.45, pitch);
}

/// A grained floor and grained upright boxes, one ray a subpixel through the exact lens.
class GrainedScene {
 public:
  CameraModel camera;
  CameraPose T_base_camera;
  std::vector<Box> boxes;
  double wall_contrast = 100.0;  // grey levels of the boxes' grain
  double wall_shift = 0.0;       // metres that it has gone over their faces

  GrainedScene(const CameraModel& camera_model, const CameraPose& pose)
      : camera(camera_model), T_base_camera(pose) {
    for (int v = 0; v < camera.height(); ++v)
      for (int u = 0; u < camera.width(); ++u)
        for (int k = 0; k < samples * samples; ++k)
          rays_.push_back(ray(u + (k / samples + 0.5) / samples - 0.5,
                              v + (k % samples + 0.5) / samples - 0.5));
  }
  /// The robot at a pose, the camera nodded and rolled about its own place.
  [[nodiscard]] Image<std::uint8_t> render(const SE2& T_odom_base,
                                           const sweep::Sway& sway = {}) const {
    const CameraPose T_odom_camera = cameraAt(T_odom_base, sway);
    return render([&](int) { return T_odom_camera; });
  }
  /// Row by row while the robot, at a pose when the middle one is read, goes on along an arc.
  [[nodiscard]] Image<std::uint8_t> render(const SE2& T_odom_base, const Velocity& velocity,
                                           double readout) const {
    return render([&](int v) {
      const double t = readout * (v / (camera.height() - 1.0) - 0.5);
      const double turn = velocity.theta * t;  // half of it turns the way
      const SE2 step = SE2{0.0, 0.0, 0.5 * turn} * SE2{velocity.x * t, velocity.y * t, 0.5 * turn};
      return cameraAt(T_odom_base * step, {});
    });
  }
  /// Distance of a floor point in odom to the outline of the nearest box.
  [[nodiscard]] double distanceToOutline(const Eigen::Vector2d& p) const {
    double nearest = 1e9;
    for (const Box& b : boxes) {
      const double dx = std::max(b.x0 - p.x(), p.x() - b.x1);
      const double dy = std::max(b.y0 - p.y(), p.y() - b.y1);
      const double inside = std::max(dx, dy);
      nearest = std::min(nearest,
                         inside < 0 ? -inside : std::hypot(std::max(dx, 0.0), std::max(dy, 0.0)));
    }
    return nearest;
  }

 private:
  static constexpr int samples = 2;  // a side

  [[nodiscard]] CameraPose cameraAt(const SE2& T_odom_base, const sweep::Sway& sway) const {
    CameraPose T_odom_camera = CameraPose::Identity();
    T_odom_camera.rotate(Eigen::AngleAxisd(T_odom_base.theta, Eigen::Vector3d::UnitZ()));
    T_odom_camera.translation() = Eigen::Vector3d(T_odom_base.x, T_odom_base.y, 0);
    T_odom_camera = T_odom_camera * T_base_camera;
    T_odom_camera.linear() =
        (Eigen::AngleAxisd(T_odom_base.theta, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(sway.pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(sway.roll, Eigen::Vector3d::UnitX()) * T_base_camera.linear())
            .matrix();
    return T_odom_camera;
  }
  template <class PoseOfRow>
  [[nodiscard]] Image<std::uint8_t> render(const PoseOfRow& poseOfRow) const {
    Image<std::uint8_t> picture(camera.width(), camera.height());
    auto next = rays_.begin();
    for (int v = 0; v < camera.height(); ++v) {
      const CameraPose T_odom_camera = poseOfRow(v);
      for (int u = 0; u < camera.width(); ++u) {
        double sum = 0.0;
        for (int k = 0; k < samples * samples; ++k)
          sum += grey(T_odom_camera.translation(), T_odom_camera.linear() * *next++);
        picture.at(u, v) = static_cast<std::uint8_t>(std::lround(sum / (samples * samples)));
      }
    }
    return picture;
  }

  [[nodiscard]] Eigen::Vector3d ray(double u_raw, double v_raw) const {
    const Intrinsics& k = camera.intrinsics();
    const double x_raw = (u_raw - k.cx) / k.fx, y_raw = (v_raw - k.cy) / k.fy;
    double x = x_raw, y = y_raw;
    for (int i = 0; i < 30; ++i) {
      double u = 0, v = 0;
      if (!camera.distortNormalized(x, y, u, v)) break;
      x += x_raw - (u - k.cx) / k.fx;
      y += y_raw - (v - k.cy) / k.fy;
    }
    return {x, y, 1.0};
  }
  [[nodiscard]] double grey(const Eigen::Vector3d& eye, const Eigen::Vector3d& direction) const {
    double nearest = 1e9, value = 150.0;
    if (direction.z() < 0.0) {
      nearest = -eye.z() / direction.z();
      const Eigen::Vector3d p = eye + nearest * direction;
      // grain fades with distance, as a lens and pixels of finite size make it
      value = 110.0 + (p - eye).norm() / ((p - eye).norm() + 1.5) * 10.0 +
              60.0 * (floor_(p.x(), p.y()) - 0.5) / (1.0 + (p - eye).squaredNorm() / 4.0);
    }
    for (const Box& box : boxes) hit(box, eye, direction, nearest, value);
    return value;
  }
  void hit(const Box& box, const Eigen::Vector3d& eye, const Eigen::Vector3d& direction,
           double& nearest, double& value) const {
    const Eigen::Vector3d low(box.x0, box.y0, 0.0), high(box.x1, box.y1, box.height);
    double enter = -1e9, leave = 1e9;
    int side = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - eye[axis]) / direction[axis];
      const double b = (high[axis] - eye[axis]) / direction[axis];
      if (std::min(a, b) > enter) side = axis;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter > leave || enter <= 0.0 || enter >= nearest) return;
    nearest = enter;
    const Eigen::Vector3d p = eye + enter * direction;
    const double s = side == 0 ? p.y() : p.x(), t = side == 2 ? p.y() : p.z();
    value = (side == 0 ? 70.0 : 85.0) + wall_contrast * (wall_(s + wall_shift, t) - 0.5);
  }

  Texture floor_{1, 0.05}, wall_{9, 0.025};
  std::vector<Eigen::Vector3d> rays_;  // optical, pixel by pixel
};

/// Parameters in proportion to the small camera's resolution.
inline sweep::SweepParameters smallParameters() {
  sweep::SweepParameters p;
  p.grid.lines_per_radian = 280.0;
  p.grid.rows_per_log = 170.0;
  p.reference.spacing = 0.01;
  p.refinement.row_step = 5;
  p.refinement.line_step = 6;
  return p;
}

/// Many pairs of many samples: for short drives of a small camera.
inline CalibrationParameters patientCalibration() {
  CalibrationParameters p;
  p.row_step = 5;
  p.line_step = 7;
  p.spacing = p.settled_spacing = 0.15;
  return p;
}

/// What a detector says at the end of a straight drive in five steps, the camera's pitch stated too
/// flat or not.
inline Obstacles answerAfter(const GrainedScene& scene, const sweep::SweepParameters& parameters,
                             double way, const CalibrationParameters& calibration = {},
                             double too_flat = 0.0) {
  sweep::SweepDetector detector(parameters, calibration);
  CameraPose T_base_stated = scene.T_base_camera;
  T_base_stated.linear() =
      Eigen::AngleAxisd(-too_flat, Eigen::Vector3d::UnitY()).matrix() * T_base_stated.linear();
  detector.setCamera(scene.camera, T_base_stated);
  Obstacles obstacles;
  for (int i = 0; i <= 5; ++i) {
    const SE2 pose{way / 5.0 * i, 0.0, 0.0};
    const Image<std::uint8_t> picture = scene.render(pose);
    Frame frame;
    frame.index = static_cast<std::uint64_t>(i);
    frame.stamp = 0.1 * i;
    frame.image = picture.view();
    frame.T_odom_base = pose;
    detector.process(frame, obstacles);
  }
  return obstacles;
}

}  // namespace ipm_mapping::test
