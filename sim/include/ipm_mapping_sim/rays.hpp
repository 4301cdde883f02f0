#pragma once
// Rays, what they meet and the surface points there: one at a time, and sixteen at once.

#include <Eigen/Core>

#include "ipm_mapping_sim/lanes.hpp"

namespace ipm_mapping::sim {

/// Names of what a ray can meet besides a patch, whose name is its index.
constexpr int kFloor = -1;
constexpr int kSky = -2;
constexpr int kNothing = -3;  ///< no ray at all

/// A ray through the middle of a pixel, and its change over one column and over one row.
struct PixelRay {
  Eigen::Vector3f origin, direction, ddx, ddy;
};

/// What a ray met: a triangle of a patch at `distance` directions; patch < 0 is nothing.
struct Hit {
  int patch = -1, prim = 0;
  float u = 0.0F, v = 0.0F, distance = 0.0F;
};

/// Rays that only ask what is in the way within `reach` directions.
struct RayPacket {
  Lanes3 origin, direction;
  Lanes reach;
};

struct HitPacket {
  IntLanes patch, prim;
  Lanes u, v, distance;

  void set(int k, const Hit& hit);
  [[nodiscard]] Hit get(int k) const;
};

struct PixelRays : RayPacket {
  Lanes3 ddx, ddy;

  void set(int k, const PixelRay& ray);
  [[nodiscard]] PixelRay get(int k) const;
  /// Fills `reach`: up to the floor, or as far as a stage is wide.
  void reachFloor();
};

/// A pixel's parallelogram on a surface: how the surface coordinates (metres) change over one
/// column and over one row.
struct FootprintPacket {
  Lanes2 dx, dy;
};

/// The visible points of sixteen pixels on one surface: where they are, and how much of it the
/// pixels cover. Lanes that are no members repeat one that is.
struct PointPacket {
  unsigned members = 0;
  float weight = 1.0F;  ///< share of a pixel's light that comes from here, at most
  Lanes3 position, normal, dpdx, dpdy;
  Lanes2 coords;  ///< metres along the surface; x and y on the floor
  FootprintPacket pixel;
  Lanes2 grid;  ///< column and row within the patch's vertices
};

/// Calls body(surface, members) for each surface among the members' surfaces.
template <class Body>
void forGroups(const IntLanes& surfaces, unsigned members, Body&& body) {
  while (members != 0) {
    const int surface = surfaces[__builtin_ctz(members)];
    unsigned group = 0;
    for (int k = 0; k < kPacket; ++k) {
      group |= static_cast<unsigned>(surfaces[k] == surface) << k;
    }
    group &= members;
    members &= ~group;
    body(surface, group);
  }
}

/// Copies of the members' rays in place, and of the first one's in all other lanes.
void select(const PixelRays& rays, unsigned members, PixelRays& out);
void select(const HitPacket& hits, unsigned members, HitPacket& out);

}  // namespace ipm_mapping::sim
