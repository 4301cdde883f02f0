#include "ipm_mapping_sim/rays.hpp"

#include <algorithm>

namespace ipm_mapping::sim {
namespace {

constexpr float kStageSize = 200.0F;

void put(Lanes3& lanes, int k, const Eigen::Vector3f& v) {
  lanes.x[k] = v.x();
  lanes.y[k] = v.y();
  lanes.z[k] = v.z();
}

Eigen::Vector3f take(const Lanes3& lanes, int k) { return {lanes.x[k], lanes.y[k], lanes.z[k]}; }

/// For each lane the one that it shows: itself, or the first member.
IntLanes sources(unsigned members) {
  IntLanes from;
  const int first = __builtin_ctz(members);
  for (int k = 0; k < kPacket; ++k) from[k] = contains(members, k) ? k : first;
  return from;
}

template <class T>
void copy(const LanesOf<T>& in, const IntLanes& from, LanesOf<T>& out) {
  for (int k = 0; k < kPacket; ++k) out[k] = in[from[k]];
}

void copy(const Lanes3& in, const IntLanes& from, Lanes3& out) {
  copy(in.x, from, out.x);
  copy(in.y, from, out.y);
  copy(in.z, from, out.z);
}

}  // namespace

void HitPacket::set(int k, const Hit& hit) {
  patch[k] = hit.patch;
  prim[k] = hit.prim;
  u[k] = hit.u;
  v[k] = hit.v;
  distance[k] = hit.distance;
}

Hit HitPacket::get(int k) const { return {patch[k], prim[k], u[k], v[k], distance[k]}; }

void PixelRays::set(int k, const PixelRay& ray) {
  put(origin, k, ray.origin);
  put(direction, k, ray.direction);
  put(ddx, k, ray.ddx);
  put(ddy, k, ray.ddy);
}

PixelRay PixelRays::get(int k) const {
  return {take(origin, k), take(direction, k), take(ddx, k), take(ddy, k)};
}

SIM_LANES void PixelRays::reachFloor() {
  Lanes out;
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float fall = -direction.z[k];
    const float floor = origin.z[k] / (fall > 1e-6F ? fall : 1e-6F);
    out[k] = fall > 1e-6F && floor < kStageSize ? floor : kStageSize;
  }
  reach = out;
}

void select(const PixelRays& rays, unsigned members, PixelRays& out) {
  const IntLanes from = sources(members);
  copy(rays.origin, from, out.origin);
  copy(rays.direction, from, out.direction);
  copy(rays.ddx, from, out.ddx);
  copy(rays.ddy, from, out.ddy);
}

void select(const HitPacket& hits, unsigned members, HitPacket& out) {
  const IntLanes from = sources(members);
  copy(hits.patch, from, out.patch);
  copy(hits.prim, from, out.prim);
  copy(hits.u, from, out.u);
  copy(hits.v, from, out.v);
  copy(hits.distance, from, out.distance);
}

}  // namespace ipm_mapping::sim
