#include "ipm_mapping_sim/stage.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace ipm_mapping::sim {
namespace {

constexpr float kStageSize = 200.0F;
constexpr float kLift = 3e-3F;  // out of a hollow surface's own triangles, still under a plank

/// Change of the points on their planes when the rays' directions change by `change`.
inline void slide(const PixelRays& rays, const Lanes& distance, const Lanes3& normal,
                  const Lanes3& change, Lanes3& out) {
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float nx = normal.x[k], ny = normal.y[k], nz = normal.z[k];
    const float dx = rays.direction.x[k], dy = rays.direction.y[k], dz = rays.direction.z[k];
    const float facing = nx * dx + ny * dy + nz * dz;
    const float safe = facing >= 0.0F ? std::max(facing, 1e-5F) : std::min(facing, -1e-5F);
    const float along = (nx * change.x[k] + ny * change.y[k] + nz * change.z[k]) / safe;
    out.x[k] = distance[k] * (change.x[k] - dx * along);
    out.y[k] = distance[k] * (change.y[k] - dy * along);
    out.z[k] = distance[k] * (change.z[k] - dz * along);
  }
}

inline void setLane(Lanes3& lanes, int k, const Eigen::Vector3f& v) {
  lanes.x[k] = v.x();
  lanes.y[k] = v.y();
  lanes.z[k] = v.z();
}

/// Changes of the surface coordinates over a pixel's change on the surface.
inline void project(const Lanes3& grad_s, const Lanes3& grad_t, const Lanes3& step, Lanes2& out) {
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float x = step.x[k], y = step.y[k], z = step.z[k];
    out.x[k] = grad_s.x[k] * x + grad_s.y[k] * y + grad_s.z[k] * z;
    out.y[k] = grad_t.x[k] * x + grad_t.y[k] * y + grad_t.z[k] * z;
  }
}

}  // namespace

Stage::Stage(const Scene& scene) : solids_(makeSolids(scene)), footprints_(footprintsOf(solids_)) {
  for (Solid& solid : solids_) {
    if (!solid.way.empty()) movers_.push_back({&solid, patches_.size(), {}, Point::Zero()});
    for (const Patch& patch : solid.patches) {
      patches_.push_back(&patch);
      moving_.push_back(!solid.way.empty());
      addFacets(patch);
      if (!solid.way.empty()) movers_.back().rest.push_back(patch.points);
    }
  }
  tracer_ = std::make_unique<Tracer>(patches_);
  if (!anyMoves()) return;
  still_ = std::make_unique<Tracer>(castersOf(Casters::Still));
  of_movers_ = std::make_unique<Tracer>(castersOf(Casters::Moving));
  moveTo(0.0);
}

bool Stage::casts(std::size_t patch, Casters casters) const {
  return casters == Casters::All || moving_[patch] == (casters == Casters::Moving);
}

std::vector<const Patch*> Stage::castersOf(Casters casters) const {
  std::vector<const Patch*> chosen;
  for (std::size_t i = 0; i < patches_.size(); ++i)
    chosen.push_back(casts(i, casters) ? patches_[i] : nullptr);
  return chosen;
}

const Tracer& Stage::tracer(Casters casters) const {
  if (casters == Casters::All || !anyMoves()) return *tracer_;
  return casters == Casters::Still ? *still_ : *of_movers_;
}

Eigen::AlignedBox2f Stage::extent(Casters casters) const {
  Eigen::AlignedBox2f extent;
  for (const Patch* patch : castersOf(casters)) {
    if (patch == nullptr) continue;
    for (const Eigen::Vector3f& p : patch->points) extent.extend(p.head<2>());
  }
  return extent;
}

bool Stage::moveTo(double time) {
  bool any = false;
  for (Mover& mover : movers_) {
    const Point gone = goneAlong(mover.solid->way, time);
    if (gone == mover.gone) continue;
    mover.gone = gone;
    shift(mover);
    any = true;
  }
  if (!any) return false;
  tracer_->commit();
  of_movers_->commit();
  return true;
}

/// Puts a moving solid where it is now.
void Stage::shift(const Mover& mover) {
  const Eigen::Vector3f by(static_cast<float>(mover.gone.x()), static_cast<float>(mover.gone.y()),
                           0.0F);
  for (std::size_t k = 0; k < mover.rest.size(); ++k) {
    const std::size_t index = mover.first_patch + k;
    Patch& patch = mover.solid->patches[k];
    for (std::size_t i = 0; i < patch.points.size(); ++i) patch.points[i] = mover.rest[k][i] + by;
    for (int prim = 0; prim < patch.triangleCount(); ++prim)
      facets_[first_facet_[index] + static_cast<std::size_t>(prim)].point[0] =
          patch.points[static_cast<std::size_t>(patch.triangle(prim)[0])];
    tracer_->update(index, patch);
    of_movers_->update(index, patch);
  }
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
    const auto edges = [&](const auto& values, auto* out) {
      out[0] = values[static_cast<std::size_t>(c[0])];
      for (int k = 1; k < 3; ++k) out[k] = values[static_cast<std::size_t>(c[k])] - out[0];
    };
    edges(patch.points, facet.point);
    edges(patch.normals, facet.shading_normal);
    edges(patch.coords, facet.coords);
    facets_.push_back(facet);
  }
}

SIM_LANES void Stage::surfacesOf(const RayPacket& rays, const HitPacket& hits, IntLanes& surfaces) {
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const int open = rays.direction.z[k] < -1e-4F ? kFloor : kSky;
    surfaces[k] = hits.patch[k] >= 0 ? hits.patch[k] : open;
  }
}

SIM_LANES void Stage::resolveFloor(const PixelRays& rays, PointPacket& points) {
  Lanes distance;
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    distance[k] = -rays.origin.z[k] / rays.direction.z[k];
    points.position.x[k] = rays.origin.x[k] + distance[k] * rays.direction.x[k];
    points.position.y[k] = rays.origin.y[k] + distance[k] * rays.direction.y[k];
    points.position.z[k] = points.normal.x[k] = points.normal.y[k] = 0.0F;
    points.normal.z[k] = 1.0F;
  }
  slide(rays, distance, points.normal, rays.ddx, points.dpdx);
  slide(rays, distance, points.normal, rays.ddy, points.dpdy);
  points.coords = {points.position.x, points.position.y};
  points.pixel = {{points.dpdx.x, points.dpdx.y}, {points.dpdy.x, points.dpdy.y}};
}

SIM_LANES void Stage::resolvePatch(int patch, const PixelRays& rays, const HitPacket& hits,
                                   PointPacket& points) const {
  const int columns = patches_[static_cast<std::size_t>(patch)]->cols - 1;
  Lanes3 plane, grad_s, grad_t;
  for (int k = 0; k < kPacket; ++k) {
    const Facet& facet = this->facet(patch, hits.prim[k]);
    const float u = hits.u[k], v = hits.v[k];
    const auto blend = [&](const auto& value) { return value[0] + u * value[1] + v * value[2]; };
    setLane(points.position, k, blend(facet.point));
    setLane(points.normal, k, blend(facet.shading_normal).normalized());
    const Eigen::Vector2f coords = blend(facet.coords);
    points.coords.x[k] = coords.x();
    points.coords.y[k] = coords.y();
    setLane(plane, k, facet.normal);
    setLane(grad_s, k, facet.grad_s);
    setLane(grad_t, k, facet.grad_t);
    const int cell = hits.prim[k] / 2;
    const bool lower = hits.prim[k] % 2 == 0;
    points.grid.x[k] = static_cast<float>(cell % columns) + u + (lower ? v : 0.0F);
    points.grid.y[k] = static_cast<float>(cell / columns) + v + (lower ? 0.0F : u);
  }
  slide(rays, hits.distance, plane, rays.ddx, points.dpdx);
  slide(rays, hits.distance, plane, rays.ddy, points.dpdy);
  project(grad_s, grad_t, points.dpdx, points.pixel.dx);
  project(grad_s, grad_t, points.dpdy, points.pixel.dy);
}

bool Stage::covered(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                    Casters casters) const {
  const Hit hit = tracer(casters).nearest(point + kLift * normal, normal, kStageSize);
  if (hit.patch < 0) return false;
  return facet(hit.patch, hit.prim).normal.dot(normal) > 0.0F;
}

}  // namespace ipm_mapping::sim
