#pragma once

#include <algorithm>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::test {

/// Darkens a picture towards its corners, where it loses this share of its brightness.
inline void shadeCorners(double shading, Image<std::uint8_t>& picture) {
  const double cu = 0.5 * (picture.width() - 1), cv = 0.5 * (picture.height() - 1);
  for (int v = 0; v < picture.height(); ++v)
    for (int u = 0; u < picture.width(); ++u) {
      const double rho2 = ((u - cu) * (u - cu) + (v - cv) * (v - cv)) / (cu * cu + cv * cv);
      picture.at(u, v) =
          static_cast<std::uint8_t>(std::lround(picture.at(u, v) * (1.0 - shading * rho2)));
    }
}

/// Drives a detector through a rendered world.
class Drive {
 public:
  explicit Drive(const sweep::SweepParameters& parameters = smallParameters(), double pitch = 0.42,
                 const CalibrationParameters& calibration = {})
      : scene(smallCamera(), smallCameraPose(pitch)), detector(parameters, calibration) {
    detector.setCamera(scene.camera, scene.T_base_camera);
  }
  FrameStatus at(const SE2& pose) { return at(pose, pose); }
  /// The robot is at a pose, its wheels say another one.
  FrameStatus at(const SE2& pose, const SE2& by_wheels) {
    Image<std::uint8_t> picture = scene.render(pose, sway);
    if (light != 1.0)
      std::transform(picture.row(0), picture.row(picture.height()), picture.row(0), [&](int grey) {
        return static_cast<std::uint8_t>(std::min(255.0, light * grey));
      });
    for (int v = 0; v < picture.height(); ++v)
      std::fill_n(picture.row(v), std::lround(dazzled * picture.width()), std::uint8_t{250});
    if (shading != 0.0) shadeCorners(shading, picture);
    Frame frame;
    frame.index = index++;
    frame.stamp = 0.1 * static_cast<double>(frame.index);
    frame.image = picture.view();
    frame.T_odom_base = by_wheels;
    last = pose;
    return detector.process(frame, obstacles);
  }
  /// Forward (or back) along x in steps; returns the last status.
  FrameStatus along(double from, double to, int steps) {
    FrameStatus status = FrameStatus::NoReference;
    for (int i = 0; i <= steps; ++i) status = at({from + (to - from) * i / steps, 0.0, 0.0});
    return status;
  }
  /// Share of the contacts within 3 cm of a box.
  [[nodiscard]] double shareOnOutlines() const {
    int good = 0;
    for (const Contact& c : obstacles.contacts)
      good += scene.distanceToOutline(last * c.p_base.cast<double>()) < 0.03;
    return obstacles.contacts.empty() ? 0.0 : good / static_cast<double>(obstacles.contacts.size());
  }
  GrainedScene scene;
  sweep::SweepDetector detector;
  Obstacles obstacles;
  std::uint64_t index = 0;
  sweep::Sway sway;      // of the camera from now on
  double light = 1.0;    // against before
  double shading = 0.0;  // of the picture's corners, by the lens
  double dazzled = 0.0;  // share of the picture, from the left
  SE2 last;
};

}  // namespace ipm_mapping::test
