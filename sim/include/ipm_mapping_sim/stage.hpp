#pragma once
// The solids of a scene, ready to be hit by rays, and where the moving ones of them are.

#include <memory>
#include <vector>

#include "ipm_mapping_sim/solids.hpp"
#include "ipm_mapping_sim/tracer.hpp"

namespace ipm_mapping::sim {

/// Which solids are asked for.
enum class Casters { All, Still, Moving };

class Stage {
 public:
  explicit Stage(const Scene& scene);

  /// Takes moving things to where they are at a time; false if that is where they were.
  bool moveTo(double time);
  [[nodiscard]] bool anyMoves() const { return !movers_.empty(); }
  [[nodiscard]] bool moves(std::size_t patch) const { return moving_[patch]; }

  /// Outlines where their x and y put them, with the ways that they go from there.
  [[nodiscard]] const std::vector<Footprint>& footprints() const { return footprints_; }
  [[nodiscard]] const Tracer& tracer(Casters casters = Casters::All) const;
  [[nodiscard]] const std::vector<const Patch*>& patches() const { return patches_; }

  /// The floor between and around the solids; empty without solids.
  [[nodiscard]] Eigen::AlignedBox2f extent(Casters casters) const;
  /// What each ray met: a patch's index, kFloor or kSky.
  static void surfacesOf(const RayPacket& rays, const HitPacket& hits, IntLanes& surfaces);
  /// Points where rays that met nothing meet the floor; all of them have to point down.
  static void resolveFloor(const PixelRays& rays, PointPacket& points);
  /// Points where rays met one patch.
  void resolvePatch(int patch, const PixelRays& rays, const HitPacket& hits,
                    PointPacket& points) const;
  /// True if the point is covered by a solid that stands on it: the first thing that a ray along
  /// the normal meets is the inside of a surface.
  [[nodiscard]] bool covered(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                             Casters casters = Casters::All) const;

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
  /// A moving solid: its patches, where they were made, and how far it has gone since.
  struct Mover {
    Solid* solid = nullptr;
    std::size_t first_patch = 0;
    std::vector<std::vector<Eigen::Vector3f>> rest;
    Point gone = Point::Zero();
  };

  void addFacets(const Patch& patch);
  [[nodiscard]] bool casts(std::size_t patch, Casters casters) const;
  [[nodiscard]] std::vector<const Patch*> castersOf(Casters casters) const;
  void shift(const Mover& mover);

  std::vector<Solid> solids_;
  std::vector<const Patch*> patches_;
  std::vector<std::size_t> first_facet_;
  std::vector<Facet> facets_;
  std::vector<Footprint> footprints_;
  std::vector<Mover> movers_;
  std::vector<bool> moving_;                   ///< of each patch
  std::unique_ptr<Tracer> tracer_;             ///< all solids
  std::unique_ptr<Tracer> still_, of_movers_;  ///< where anything moves
};

}  // namespace ipm_mapping::sim
