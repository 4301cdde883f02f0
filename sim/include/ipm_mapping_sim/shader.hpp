#pragma once
// How bright a visible point looks.

#include <memory>
#include <vector>

#include "ipm_mapping_sim/floor.hpp"
#include "ipm_mapping_sim/light_map.hpp"
#include "ipm_mapping_sim/stage.hpp"

namespace ipm_mapping::sim {

/// The mirrored rays of glossy floor points and the shares of light that come along them.
struct Mirrors {
  PixelRays rays;
  Lanes share;
};

class Shader {
 public:
  Shader(const Scene& scene, const Stage& stage);

  /// Something on the stage has moved.
  void forgetMoved();

  [[nodiscard]] bool glossyFloor() const { return scene_.floor.reflection > 0.0; }
  /// Radiance of the members' surface, which is `surface` for all of them. Where it is a glossy
  /// floor `mirrors` is filled, and the radiance is without what comes along the mirrored rays.
  /// `weight`: at most this share of a pixel's light comes from here.
  void radiance(int surface, unsigned members, const PixelRays& rays, const HitPacket& hits,
                float weight, Lanes& out, Mirrors& mirrors);

 private:
  struct Lit {
    Lanes diffuse, lamp[kMaxLamps];
    Lanes3 to_lamp[kMaxLamps];  ///< unit vectors
  };
  void sky(const PixelRays& rays, Lanes& out) const;
  void solid(int patch, const PointPacket& points, Lanes& out);
  [[nodiscard]] LightMap& floorMap(const PointPacket& points);
  void floor(const PointPacket& points, const PixelRays& rays, Lanes& out, Mirrors& mirrors);
  void light(LightMap& map, const PointPacket& points, Lit& lit);
  void addLamp(std::size_t index, const PointPacket& points, LightShares& shares, Lit& lit) const;
  void sharesOf(LightMap& map, const PointPacket& points, LightShares& shares) const;
  void albedoOf(int patch, const PointPacket& points, Lanes& out) const;
  void addHighlights(std::size_t index, const Lanes3& normal, const Lanes3& to_eye, const Lit& lit,
                     Lanes& sum) const;
  void mirror(const Lanes3& normal, const Lanes3& to_eye, const Lanes& gloss,
              const PointPacket& points, const PixelRays& rays, Mirrors& mirrors) const;

  const Scene& scene_;
  const Stage& stage_;
  TextureSet textures_;
  Floor floor_;
  LightMap floor_map_, far_floor_map_, moving_floor_map_;
  std::vector<std::unique_ptr<LightMap>> maps_;
  std::vector<const Texture*> grains_;
};

}  // namespace ipm_mapping::sim
