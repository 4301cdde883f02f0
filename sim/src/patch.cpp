#include "ipm_mapping_sim/patch.hpp"

#include <cmath>

namespace ipm_mapping::sim {

using Eigen::Vector3d;
using Eigen::Vector3f;

Eigen::Vector3i Patch::triangle(int prim) const {
  const int cell = prim / 2, r = cell / (cols - 1), c = cell % (cols - 1);
  const int v00 = r * cols + c, v10 = v00 + cols;
  if (prim % 2 == 0) return {v00, v00 + 1, v10 + 1};
  return {v00, v10 + 1, v10};
}

Eigen::Vector3d Placement::operator()(double px, double py, double pz) const {
  const Point p = (*this)(px, py);
  return {p.x(), p.y(), z + pz};
}

Point Placement::operator()(double px, double py) const {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {x + c * px - s * py, y + s * px + c * py};
}

Patch quadPatch(const Vector3d& corner, const Vector3d& u, const Vector3d& v,
                const Material& material) {
  Patch patch{2, 2, {}, {}, {}, material};
  const Vector3f normal = u.cross(v).normalized().cast<float>();
  const bool upright = material.grain == Grain::Wood && material.pattern == Pattern::None &&
                       v.norm() > u.norm();  // wood is cut along its grain
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 2; ++c) {
      patch.points.push_back((corner + c * u + r * v).cast<float>());
      patch.normals.push_back(normal);
      const Eigen::Vector2d at(c * u.norm(), r * v.norm());
      patch.coords.push_back((upright ? at.reverse().eval() : at).cast<float>());
    }
  }
  return patch;
}

void addBox(const Placement& at, const Eigen::AlignedBox3d& box, const Material& material,
            std::vector<Patch>& out) {
  const Vector3d a = box.min(), b = box.max();
  const Vector3d x = at(1, 0, 0) - at(0, 0, 0), y = at(0, 1, 0) - at(0, 0, 0);
  const Vector3d dx = x * (b.x() - a.x()), dy = y * (b.y() - a.y());
  const Vector3d dz = Vector3d::UnitZ() * (b.z() - a.z());
  const Vector3d low = at(a.x(), a.y(), a.z());
  out.push_back(quadPatch(low, dx, dz, material));             // right side
  out.push_back(quadPatch(low + dx, dy, dz, material));        // front
  out.push_back(quadPatch(low + dx + dy, -dx, dz, material));  // left side
  out.push_back(quadPatch(low + dy, -dy, dz, material));       // back
  out.push_back(quadPatch(low + dz, dx, dy, material));        // top
  out.push_back(quadPatch(low, dy, dx, material));             // underside
}

Patch revolvedPatch(const Placement& at, double r0, double z0, double r1, double z1, int segments,
                    const Material& material) {
  Patch patch{2, segments + 1, {}, {}, {}, material};
  const double slope = std::hypot(r1 - r0, z1 - z0), radius = std::max(r0, r1);
  for (int row = 0; row < 2; ++row) {
    const double r = row == 0 ? r0 : r1, z = row == 0 ? z0 : z1;
    for (int i = 0; i <= segments; ++i) {
      const double a = 2.0 * M_PI * (i % segments) / segments, c = std::cos(a), s = std::sin(a);
      patch.points.push_back(at(r * c, r * s, z).cast<float>());
      const Vector3d outward(c * (z1 - z0), s * (z1 - z0), r0 - r1);
      const Vector3d turned = at(outward.x(), outward.y(), outward.z()) - at(0, 0, 0);
      patch.normals.push_back(turned.normalized().cast<float>());
      patch.coords.emplace_back(2.0 * M_PI * radius * i / segments, row * slope);
    }
  }
  return patch;
}

Patch discPatch(const Placement& at, double r, double z, int segments, const Material& material,
                Facing facing) {
  const bool up = facing == Facing::Up;
  Patch patch = revolvedPatch(at, up ? r : 0.0, z, up ? 0.0 : r, z, segments, material);
  const Vector3f normal(0.0F, 0.0F, up ? 1.0F : -1.0F);
  for (std::size_t i = 0; i < patch.points.size(); ++i) {
    patch.normals[i] = normal;
    patch.coords[i] = patch.points[i].head<2>();
  }
  return patch;
}

std::vector<Point> circlePolygon(const Placement& at, double r, int segments) {
  std::vector<Point> polygon;
  for (int i = 0; i < segments; ++i) {
    const double a = 2.0 * M_PI * i / segments;
    polygon.push_back(at(r * std::cos(a), r * std::sin(a)));
  }
  return polygon;
}

}  // namespace ipm_mapping::sim
