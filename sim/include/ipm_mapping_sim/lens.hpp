#pragma once
// Rays of a camera's pixels: the inverse of the camera model's distortion.

#include <Eigen/Geometry>
#include <vector>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping_sim/scene.hpp"

namespace ipm_mapping::sim {

/// The scene's camera as the robot's software is told about it.
CameraModel cameraModel(const CameraSpec& camera);
/// Where the software is told that the camera sits, and where it really does.
CameraPose statedPose(const CameraSpec& camera);
CameraPose truePose(const CameraSpec& camera);

/// Direction (x, y, 1) in optical coordinates of each pixel's centre; `seen` is false where the
/// lens model has no such ray.
class Lens {
 public:
  explicit Lens(const CameraModel& model);

  struct Pixel {
    Eigen::Vector2f at, dx, dy;  ///< direction, and its change over one column and one row
    bool seen = false;
  };
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] const Pixel& pixel(int u, int v) const {
    return pixels_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(u)];
  }

  /// Normalised undistorted point of a raw pixel by Newton's method; false if there is none.
  static bool undistort(const CameraModel& model, double u, double v, Eigen::Vector2d& point);

 private:
  int width_, height_;
  std::vector<Pixel> pixels_;
};

}  // namespace ipm_mapping::sim
