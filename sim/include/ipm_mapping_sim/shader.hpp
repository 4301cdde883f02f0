#pragma once
// How bright a visible point looks.

#include <memory>
#include <vector>

#include "ipm_mapping_sim/floor.hpp"
#include "ipm_mapping_sim/light_map.hpp"
#include "ipm_mapping_sim/stage.hpp"

namespace ipm_mapping::sim {

/// The mirrored ray of a glossy floor point and the share of light that comes along it.
struct Mirror {
  PixelRay ray;
  float share = 0.0F;
};

class Shader {
 public:
  Shader(const Scene& scene, const Stage& stage);

  [[nodiscard]] bool glossyFloor() const { return scene_.floor.reflection > 0.0; }
  /// Light of the ceiling and the lamps along a ray that meets nothing.
  [[nodiscard]] float sky(const Eigen::Vector3f& direction) const;
  /// Radiance of a solid's surface.
  float solid(const SurfacePoint& point);
  /// Radiance of the floor without its mirror image; `mirror` is filled on a glossy floor.
  float floor(const SurfacePoint& point, const PixelRay& ray, Mirror& mirror);
  /// Any of the three.
  float radiance(const SurfacePoint& point, const PixelRay& ray, Mirror& mirror);

 private:
  struct Lit {
    float diffuse = 0.0F, lamp[kMaxLamps] = {};
    Eigen::Vector3f to_lamp[kMaxLamps];  ///< unit vectors, of the lamps with light
  };
  Lit light(LightMap& map, const SurfacePoint& point) const;
  [[nodiscard]] float albedoOf(const SurfacePoint& point) const;
  [[nodiscard]] float highlights(const Eigen::Vector3f& normal, const Eigen::Vector3f& to_eye,
                                 const Lit& lit) const;

  const Scene& scene_;
  const Stage& stage_;
  TextureSet textures_;
  Floor floor_;
  LightMap floor_map_;
  std::vector<std::unique_ptr<LightMap>> maps_;
  std::vector<const Texture*> grains_;
};

}  // namespace ipm_mapping::sim
