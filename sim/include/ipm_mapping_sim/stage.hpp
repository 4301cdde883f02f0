#pragma once
// The solids of a scene, ready to be hit by rays.

#include <memory>
#include <vector>

#include "ipm_mapping_sim/solids.hpp"
#include "ipm_mapping_sim/tracer.hpp"

namespace ipm_mapping::sim {

class Stage {
 public:
  explicit Stage(const Scene& scene);

  [[nodiscard]] const std::vector<Footprint>& footprints() const { return footprints_; }
  [[nodiscard]] const Tracer& tracer() const { return *tracer_; }
  [[nodiscard]] const std::vector<const Patch*>& patches() const { return patches_; }

  /// The floor between and around the solids; empty without solids.
  [[nodiscard]] const Eigen::AlignedBox2f& extent() const { return extent_; }
  /// What each ray met: a patch's index, kFloor or kSky.
  static void surfacesOf(const RayPacket& rays, const HitPacket& hits, IntLanes& surfaces);
  /// Points where rays that met nothing meet the floor; all of them have to point down.
  static void resolveFloor(const PixelRays& rays, PointPacket& points);
  /// Points where rays met one patch.
  void resolvePatch(int patch, const PixelRays& rays, const HitPacket& hits,
                    PointPacket& points) const;
  /// True if the point is covered by a solid that stands on it: the first thing that a ray along
  /// the normal meets is the inside of a surface.
  [[nodiscard]] bool covered(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  /// A triangle: values at its first corner and their changes along its two edges from there.
  struct Facet {
    Eigen::Vector3f normal, grad_s, grad_t;  ///< gradients of the coords along the plane
    Eigen::Vector3f point[3], shading_normal[3];
    Eigen::Vector2f coords[3];
  };
  [[nodiscard]] const Facet& facet(int patch, int prim) const {
    return facets_[first_facet_[static_cast<std::size_t>(patch)] + static_cast<std::size_t>(prim)];
  }
  void addFacets(const Patch& patch);

  std::vector<Solid> solids_;
  std::vector<const Patch*> patches_;
  std::vector<std::size_t> first_facet_;
  std::vector<Facet> facets_;
  std::vector<Footprint> footprints_;
  Eigen::AlignedBox2f extent_;
  std::unique_ptr<Tracer> tracer_;
};

}  // namespace ipm_mapping::sim
