#pragma once
// The solids of a scene, ready to be hit by rays.

#include <cmath>
#include <memory>
#include <vector>

#include "ipm_mapping_sim/solids.hpp"
#include "ipm_mapping_sim/texture.hpp"
#include "ipm_mapping_sim/tracer.hpp"

namespace ipm_mapping::sim {

/// Names of what a ray can meet besides a patch.
constexpr int kFloor = -1;
constexpr int kSky = -2;

/// A ray through the middle of a pixel, and its change over one column and over one row.
struct PixelRay {
  Eigen::Vector3f origin, direction, ddx, ddy;

  [[nodiscard]] Eigen::Vector3f at(float distance) const { return origin + distance * direction; }
};

/// The visible point of a pixel: where it is and how much of the surface the pixel covers.
struct SurfacePoint {
  int surface = kSky;
  float weight = 1.0F;  ///< share of the pixel's light that comes from here
  Eigen::Vector3f position, normal, dpdx, dpdy;
  Eigen::Vector2f coords;  ///< metres along the surface; x and y on the floor
  Footprint2 pixel;        ///< of the coords
  Eigen::Vector2f grid;    ///< column and row within the patch's vertices
};

class Stage {
 public:
  explicit Stage(const Scene& scene);

  [[nodiscard]] const std::vector<Footprint>& footprints() const { return footprints_; }
  [[nodiscard]] const Tracer& tracer() const { return *tracer_; }
  [[nodiscard]] const std::vector<const Patch*>& patches() const { return patches_; }

  /// Farthest that a ray can go before it meets the floor, or a stage's size.
  [[nodiscard]] static float reach(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction);
  /// What a ray met: a patch's index, kFloor or kSky.
  [[nodiscard]] static int surfaceOf(const Hit& hit, const Eigen::Vector3f& direction);
  /// The floor between and around the solids; empty without solids.
  [[nodiscard]] const Eigen::AlignedBox2f& extent() const { return extent_; }
  [[nodiscard]] SurfacePoint resolve(const PixelRay& ray, const Hit& hit) const;
  /// True if the point is covered by a solid that stands on it: the first thing that a ray along
  /// the normal meets is the inside of a surface.
  [[nodiscard]] bool covered(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  struct Facet {
    Eigen::Vector3f normal, grad_s, grad_t;  ///< gradients of the coords along the plane
  };
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
