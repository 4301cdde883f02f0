#include "ipm_mapping/geometry/vanishing_point.hpp"

namespace ipm_mapping {

VanishingPoints vanishingPoints(const GroundView& view) {
  const Eigen::Matrix3d H_c = view.H_c();
  const Eigen::Vector2d foot_reference = view.cameraFoot();
  const Eigen::Vector2d foot_current = view.motion * foot_reference;
  return {H_c * foot_current.homogeneous(), H_c * foot_reference.homogeneous()};
}

Focus midFootFocus(const VanishingPoints& points) { return {points.f1 + points.f2}; }

Focus meanPixelFocus(const VanishingPoints& points) {
  if (!(points.f1.z() > 0.0 && points.f2.z() > 0.0)) return midFootFocus(points);
  const Eigen::Vector2d mean = 0.5 * (points.f1.hnormalized() + points.f2.hnormalized());
  return {mean.homogeneous()};
}

}  // namespace ipm_mapping
