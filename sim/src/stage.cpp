#include "ipm_mapping_sim/stage.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace ipm_mapping::sim {
namespace {

constexpr float kStageSize = 200.0F;
constexpr float kLift = 3e-3F;  // out of a hollow surface's own triangles, still under a plank

/// Change of the point on the plane when the ray's direction changes by `change`.
Eigen::Vector3f slide(const PixelRay& ray, float distance, const Eigen::Vector3f& normal,
                      const Eigen::Vector3f& change) {
  const float facing = normal.dot(ray.direction);
  const float safe = std::abs(facing) < 1e-5F ? std::copysign(1e-5F, facing) : facing;
  return distance * (change - ray.direction * (normal.dot(change) / safe));
}

}  // namespace

Stage::Stage(const Scene& scene) : solids_(makeSolids(scene)), footprints_(footprintsOf(solids_)) {
  for (const Solid& solid : solids_) {
    for (const Patch& patch : solid.patches) {
      patches_.push_back(&patch);
      addFacets(patch);
      for (const Eigen::Vector3f& p : patch.points) extent_.extend(p.head<2>());
    }
  }
  tracer_ = std::make_unique<Tracer>(patches_);
}

void Stage::addFacets(const Patch& patch) {
  first_facet_.push_back(facets_.size());
  for (int prim = 0; prim < patch.triangleCount(); ++prim) {
    const Eigen::Vector3i c = patch.triangle(prim);
    const auto point = [&](int k) { return patch.points[static_cast<std::size_t>(c[k])]; };
    const auto coord = [&](int k) { return patch.coords[static_cast<std::size_t>(c[k])]; };
    const Eigen::Vector3f e1 = point(1) - point(0), e2 = point(2) - point(0);
    Facet facet;
    facet.normal = e1.cross(e2);
    const float area = facet.normal.norm();
    facet.grad_s = facet.grad_t = Eigen::Vector3f::Zero();
    if (area > 1e-10F) {
      facet.normal /= area;
      // Dual basis of the triangle's edges within its plane.
      const Eigen::Vector3f d1 = e2.cross(facet.normal) / area, d2 = facet.normal.cross(e1) / area;
      const Eigen::Vector2f s1 = coord(1) - coord(0), s2 = coord(2) - coord(0);
      facet.grad_s = s1.x() * d1 + s2.x() * d2;
      facet.grad_t = s1.y() * d1 + s2.y() * d2;
    }
    facets_.push_back(facet);
  }
}

float Stage::reach(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
  return direction.z() < -1e-6F ? std::min(-origin.z() / direction.z(), kStageSize) : kStageSize;
}

int Stage::surfaceOf(const Hit& hit, const Eigen::Vector3f& direction) {
  if (hit.patch >= 0) return hit.patch;
  return direction.z() < -1e-4F ? kFloor : kSky;
}

SurfacePoint Stage::resolve(const PixelRay& ray, const Hit& hit) const {
  SurfacePoint point;
  point.surface = surfaceOf(hit, ray.direction);
  if (point.surface == kSky) return point;
  if (point.surface == kFloor) {
    const float distance = -ray.origin.z() / ray.direction.z();
    point.normal = Eigen::Vector3f::UnitZ();
    point.position = ray.at(distance);
    point.position.z() = 0.0F;
    point.dpdx = slide(ray, distance, point.normal, ray.ddx);
    point.dpdy = slide(ray, distance, point.normal, ray.ddy);
    point.coords = point.position.head<2>();
    point.pixel = {point.dpdx.head<2>(), point.dpdy.head<2>()};
    return point;
  }
  const Patch& patch = *patches_[static_cast<std::size_t>(hit.patch)];
  const Facet& facet = facets_[first_facet_[static_cast<std::size_t>(hit.patch)] +
                               static_cast<std::size_t>(hit.prim)];
  const Eigen::Vector3i c = patch.triangle(hit.prim);
  const auto blend = [&](const auto& values) {
    return ((1.0F - hit.u - hit.v) * values[static_cast<std::size_t>(c[0])] +
            hit.u * values[static_cast<std::size_t>(c[1])] +
            hit.v * values[static_cast<std::size_t>(c[2])])
        .eval();
  };
  point.position = blend(patch.points);
  point.normal = blend(patch.normals).normalized();
  point.coords = blend(patch.coords);
  point.dpdx = slide(ray, hit.distance, facet.normal, ray.ddx);
  point.dpdy = slide(ray, hit.distance, facet.normal, ray.ddy);
  point.pixel = {{facet.grad_s.dot(point.dpdx), facet.grad_t.dot(point.dpdx)},
                 {facet.grad_s.dot(point.dpdy), facet.grad_t.dot(point.dpdy)}};
  const int cell = hit.prim / 2, column = cell % (patch.cols - 1), row = cell / (patch.cols - 1);
  const bool lower = hit.prim % 2 == 0;
  point.grid = {static_cast<float>(column) + hit.u + (lower ? hit.v : 0.0F),
                static_cast<float>(row) + hit.v + (lower ? 0.0F : hit.u)};
  return point;
}

bool Stage::covered(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const {
  const Hit hit = tracer_->nearest(point + kLift * normal, normal, kStageSize);
  if (hit.patch < 0) return false;
  const Facet& facet = facets_[first_facet_[static_cast<std::size_t>(hit.patch)] +
                               static_cast<std::size_t>(hit.prim)];
  return facet.normal.dot(normal) > 0.0F;
}

}  // namespace ipm_mapping::sim
