#include "ipm_mapping/stages/birds_eye.hpp"

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {

BirdsEye BirdsEye::over(const GroundView& view, double span) {
  const Intrinsics& k = view.camera.intrinsics();
  BirdsEye result;
  result.metres_per_pixel = span / k.width;
  const Eigen::Vector2d foot = view.cameraFoot();
  result.mid_foot = 0.5 * (foot + view.motion.inverse() * foot);
  const double m = result.metres_per_pixel;
  Eigen::Matrix3d output_to_floor;
  output_to_floor << 0, -m, result.mid_foot.x() + m * k.cy,  //
      -m, 0, result.mid_foot.y() + m * k.cx,                 //
      0, 0, 1;
  result.to_input = groundHomography(k, view.T_base_camera) * output_to_floor;
  return result;
}

void birdsEyeView(const BirdsEye& birds_eye, GrayView obstacle_mask, GrayBuffer out) {
  const Eigen::Matrix3d& B = birds_eye.to_input;
  for (int V = 0; V < out.height; ++V) {
    std::uint8_t* row = out.row(V);
    const Eigen::Vector3d start = B.col(1) * V + B.col(2);
    for (int U = 0; U < out.width; ++U) {
      const Eigen::Vector3d p = B.col(0) * U + start;
      row[U] = mask::unseen;
      if (!(p.z() > 0.0)) continue;
      const double u = p.x() / p.z() + 0.5, v = p.y() / p.z() + 0.5;
      if (u >= 0.0 && v >= 0.0 && u < obstacle_mask.width && v < obstacle_mask.height)
        row[U] = obstacle_mask.at(static_cast<int>(u), static_cast<int>(v));
    }
  }
}

}  // namespace ipm_mapping
