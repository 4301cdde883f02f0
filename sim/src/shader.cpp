#include "ipm_mapping_sim/shader.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

using Eigen::Vector3f;

constexpr float kFloorTexel = 0.01F, kFarFloorTexel = 0.04F, kSolidTexel = 0.02F;
constexpr float kMovingTexel = 0.02F;  // made anew for every frame
constexpr float kGrazingMirror = 0.6F;
constexpr float kVisibleContrast = 0.004F;  // below the sensor's noise
constexpr float kFaintest = 0.35F;          // share of light whose shadows' edges are worth a ray

/// Share of the pattern's second reflectance under a pixel of extents wide_s and wide_t.
inline float patternShare(Pattern pattern, float period, float s, float t, float wide_s,
                          float wide_t) {
  switch (pattern) {
    case Pattern::None:
      return 0.0F;
    case Pattern::Bands:
      return gapCoverage(t - 0.75F * period, wide_t, period, 0.5F * period);
    case Pattern::Carton:  // a strip of tape and a label beside it
      return std::max(gapCoverage(s - 0.5F * period, wide_s, 20.0F * period, 0.05F),
                      gapCoverage(s - 0.85F * period, wide_s, 20.0F * period, 0.1F) *
                          gapCoverage(t - 0.6F * period, wide_t, 20.0F * period, 0.07F));
    case Pattern::Books:
      return gapCoverage(s, wide_s, 0.31F * period, 0.13F * period) *
             (1.0F - gapCoverage(t, wide_t, period, 0.12F * period));
  }
  return 0.0F;
}

/// Materials' colours with their patterns.
inline void patterned(const Material& material, const PointPacket& points, Lanes& out) {
  const auto plain = static_cast<float>(material.albedo);
  const auto marked = static_cast<float>(material.pattern_albedo);
  const auto period = static_cast<float>(material.pattern_period);
  const FootprintPacket& pixel = points.pixel;
  fill(out, plain);
  if (material.pattern == Pattern::None) return;
  for (int k = 0; k < kPacket; ++k) {
    const float share = patternShare(material.pattern, period, points.coords.x[k],
                                     points.coords.y[k], extentAlong(pixel.dx.x[k], pixel.dy.x[k]),
                                     extentAlong(pixel.dx.y[k], pixel.dy.y[k]));
    out[k] += share * (marked - plain);
  }
}

Vector3f laneOf(const Lanes3& lanes, int k) { return {lanes.x[k], lanes.y[k], lanes.z[k]}; }

/// Slopes of the floor's cells as unit normals.
inline void normalsOf(const Lanes2& tilt, Lanes3& out) {
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float x = tilt.x[k], y = tilt.y[k], scale = 1.0F / std::sqrt(x * x + y * y + 1.0F);
    out.x[k] = scale * x;
    out.y[k] = scale * y;
    out.z[k] = scale;
  }
}

inline void towardsEye(const Lanes3& direction, Lanes3& out) {
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float x = direction.x[k], y = direction.y[k], z = direction.z[k];
    const float scale = -1.0F / std::sqrt(x * x + y * y + z * z);
    out.x[k] = scale * x;
    out.y[k] = scale * y;
    out.z[k] = scale * z;
  }
}

inline void reflect(const Lanes3& v, const Lanes3& normal, Lanes3& out) {
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float nx = normal.x[k], ny = normal.y[k], nz = normal.z[k];
    const float twice = 2.0F * (v.x[k] * nx + v.y[k] * ny + v.z[k] * nz);
    out.x[k] = v.x[k] - twice * nx;
    out.y[k] = v.y[k] - twice * ny;
    out.z[k] = v.z[k] - twice * nz;
  }
}

}  // namespace

Shader::Shader(const Scene& scene, const Stage& stage)
    : scene_(scene),
      stage_(stage),
      textures_(static_cast<std::uint64_t>(scene.seed)),
      floor_(scene, textures_),
      floor_map_(stage, Casters::Still, scene.lamps, nullptr, kFloorTexel),
      far_floor_map_(stage, Casters::Still, scene.lamps, nullptr, kFarFloorTexel),
      moving_floor_map_(stage, Casters::Moving, scene.lamps, nullptr, kMovingTexel) {
  if (scene.lamps.size() > kMaxLamps) {
    throw ParameterError("scene: lamps are " + std::to_string(scene.lamps.size()) +
                         ", must be at most " + std::to_string(kMaxLamps));
  }
  for (std::size_t i = 0; i < stage.patches().size(); ++i) {
    const Patch* patch = stage.patches()[i];
    const Casters casters = stage.moves(i) ? Casters::All : Casters::Still;
    maps_.push_back(std::make_unique<LightMap>(stage, casters, scene.lamps, patch, kSolidTexel));
    grains_.push_back(textures_.get(patch->material.grain));
  }
}

void Shader::forgetMoved() {
  moving_floor_map_.forget();
  for (std::size_t i = 0; i < maps_.size(); ++i)
    if (stage_.moves(i)) maps_[i]->forget();
}

SIM_LANES void Shader::sky(const PixelRays& rays, Lanes& out) const {
  const auto ceiling = static_cast<float>(scene_.ceiling);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    out[k] = ceiling * (0.75F + 0.25F * std::max(0.0F, rays.direction.z[k]));
  }
}

/// Asks the map, and the ray tracer where that is too coarse for a shadow's edge.
void Shader::sharesOf(LightMap& map, const PointPacket& points, LightShares& shares) const {
  map.at(points, shares);
  if (points.weight <= kFaintest) return;
  for (std::size_t index = 0; index < scene_.lamps.size(); ++index) {
    const LampSpec& lamp = scene_.lamps[index];
    const Vector3f at = lamp.at.cast<float>();
    forMembers(shares.steep[index] & points.members, [&](int k) {
      const Texel pixel{laneOf(points.position, k), laneOf(points.normal, k),
                        laneOf(points.dpdx, k), laneOf(points.dpdy, k)};
      if ((at - pixel.centre).dot(pixel.normal) <= 0.0F) return;
      shares.lamp[index][k] = lampShare(map.tracer(), lamp, pixel, kWholeLamp);
    });
  }
}

/// Light of a lamp, relative to the floor straight below it.
SIM_LANES void Shader::addLamp(std::size_t index, const PointPacket& points, LightShares& shares,
                               Lit& lit) const {
  const LampSpec& lamp = scene_.lamps[index];
  const auto x = static_cast<float>(lamp.at.x()), y = static_cast<float>(lamp.at.y());
  const auto z = static_cast<float>(lamp.at.z());
  const float energy = static_cast<float>(lamp.energy) * z * z;
  const bool panel = lamp.size > 0.0;
  const Lanes& share = shares.lamp[index];
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float dx = x - points.position.x[k], dy = y - points.position.y[k];
    const float dz = z - points.position.z[k], square = dx * dx + dy * dy + dz * dz;
    const float inverse = 1.0F / std::sqrt(square);
    const float facing =
        inverse * (dx * points.normal.x[k] + dy * points.normal.y[k] + dz * points.normal.z[k]);
    const float spread = panel ? std::max(0.0F, inverse * dz) : 1.0F;
    const float light = facing > 0.0F ? share[k] * energy / square * spread : 0.0F;
    lit.to_lamp[index].x[k] = inverse * dx;
    lit.to_lamp[index].y[k] = inverse * dy;
    lit.to_lamp[index].z[k] = inverse * dz;
    lit.lamp[index][k] = light;
    lit.diffuse[k] += light * facing;
  }
}

/// Moving things darken the floor and one another; of what stands still they darken nothing.
void Shader::light(LightMap& map, const PointPacket& points, Lit& lit) {
  LightShares shares;
  sharesOf(map, points, shares);
  const bool on_floor = &map == &floor_map_ || &map == &far_floor_map_;
  if (on_floor && stage_.anyMoves()) {
    LightShares moving;
    sharesOf(moving_floor_map_, points, moving);
    for (int k = 0; k < kPacket; ++k) shares.ambient[k] *= moving.ambient[k];
    for (std::size_t lamp = 0; lamp < scene_.lamps.size(); ++lamp)
      for (int k = 0; k < kPacket; ++k) shares.lamp[lamp][k] *= moving.lamp[lamp][k];
  }
  const auto ambient = static_cast<float>(scene_.ambient);
  for (int k = 0; k < kPacket; ++k) {
    lit.diffuse[k] = ambient * shares.ambient[k] * (0.8F + 0.2F * points.normal.z[k]);
  }
  for (std::size_t k = 0; k < scene_.lamps.size(); ++k) {
    addLamp(k, points, shares, lit);
  }
}

SIM_LANES void Shader::albedoOf(int patch, const PointPacket& points, Lanes& out) const {
  const auto index = static_cast<std::size_t>(patch);
  const Material& material = stage_.patches()[index]->material;
  patterned(material, points, out);
  const auto contrast = static_cast<float>(material.grain_contrast);
  Lanes grain;
  fill(grain, 0.0F);
  if (grains_[index] != nullptr && contrast * points.weight > kVisibleContrast) {
    const auto size = static_cast<float>(material.grain_size);
    const float shift = 0.37F * static_cast<float>(index) * size;  // no two patches alike
    Lanes2 at;
#pragma omp simd
    for (int k = 0; k < kPacket; ++k) {
      at.x[k] = points.coords.x[k] + shift;
      at.y[k] = points.coords.y[k] + shift;
    }
    grains_[index]->sample(at, points.pixel, size, grain);
  }
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    out[k] = std::min(std::max(out[k] * (1.0F + contrast * grain[k]), 0.0F), 1.0F);
  }
}

void Shader::solid(int patch, const PointPacket& points, Lanes& out) {
  Lit lit;
  light(*maps_[static_cast<std::size_t>(patch)], points, lit);
  albedoOf(patch, points, out);
  for (int k = 0; k < kPacket; ++k) out[k] *= lit.diffuse[k];
}

/// Adds a lamp's highlight: the half-way vector's cosine to the normal, to a power.
SIM_LANES void Shader::addHighlights(std::size_t index, const Lanes3& normal, const Lanes3& to_eye,
                                     const Lit& lit, Lanes& sum) const {
  const LampSpec& lamp = scene_.lamps[index];
  // A panel's highlight is wider than a point's by its own angle.
  const auto spread = static_cast<float>(lamp.size / lamp.at.z());
  const auto shine = static_cast<float>(scene_.floor.shininess);
  const float exponent = shine / (1.0F + shine * spread * spread / 8.0F);
  const float strength = static_cast<float>(scene_.floor.specular) * exponent / shine;
  const float lowest = std::max(1.0F - 9.0F / exponent, 0.01F);  // e^-9 of the peak
  const Lanes3& l = lit.to_lamp[index];
  Lanes half;
  int seen = 0;
#pragma omp simd reduction(+ : seen)
  for (int k = 0; k < kPacket; ++k) {
    const float nx = normal.x[k], ny = normal.y[k], nz = normal.z[k];
    const float ex = to_eye.x[k], ey = to_eye.y[k], ez = to_eye.z[k];
    const float facing = nx * (l.x[k] + ex) + ny * (l.y[k] + ey) + nz * (l.z[k] + ez);
    const float between = ex * l.x[k] + ey * l.y[k] + ez * l.z[k];
    half[k] = facing / std::sqrt(std::max(2.0F + 2.0F * between, 1e-6F));
    seen += static_cast<int>(half[k] > lowest);
  }
  if (seen == 0) return;
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float peak = exp2Of(exponent * log2Of(std::max(half[k], lowest)));
    sum[k] += half[k] > lowest ? strength * lit.lamp[index][k] * peak : 0.0F;
  }
}

/// The eye's own mirror image, under the floor where nothing is in the way, sees what the floor
/// mirrors, with footprints that grow along the whole path.
SIM_LANES void Shader::mirror(const Lanes3& normal, const Lanes3& to_eye, const Lanes& gloss,
                              const PointPacket& points, const PixelRays& rays,
                              Mirrors& mirrors) const {
  const auto straight = static_cast<float>(scene_.floor.reflection);
  PixelRays& out = mirrors.rays;
  reflect(rays.direction, normal, out.direction);
  reflect(rays.ddx, normal, out.ddx);
  reflect(rays.ddy, normal, out.ddy);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float facing =
        normal.x[k] * to_eye.x[k] + normal.y[k] * to_eye.y[k] + normal.z[k] * to_eye.z[k];
    const float a = 1.0F - std::max(0.0F, facing), grazing = a * a * a * a * a;  // Schlick
    mirrors.share[k] = gloss[k] * (straight + (1.0F - straight) * kGrazingMirror * grazing);
    const float distance = -rays.origin.z[k] / rays.direction.z[k];
    out.origin.x[k] = points.position.x[k] - distance * out.direction.x[k];
    out.origin.y[k] = points.position.y[k] - distance * out.direction.y[k];
    out.origin.z[k] = points.position.z[k] - distance * out.direction.z[k];
  }
}

/// Where a pixel is longer than a coarse square, nobody sees the fine ones.
LightMap& Shader::floorMap(const PointPacket& points) {
  float shortest = kFarFloorTexel;
  forMembers(points.members, [&](int k) {
    shortest = std::min(shortest, std::max(extentAlong(points.dpdx.x[k], points.dpdy.x[k]),
                                           extentAlong(points.dpdx.y[k], points.dpdy.y[k])));
  });
  return shortest < kFarFloorTexel ? floor_map_ : far_floor_map_;
}

SIM_LANES void Shader::floor(const PointPacket& points, const PixelRays& rays, Lanes& out,
                             Mirrors& mirrors) {
  FloorLook look;
  floor_.at(points, look);
  Lit lit;
  light(floorMap(points), points, lit);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) out[k] = look.albedo[k] * lit.diffuse[k];
  if (scene_.floor.specular <= 0.0 && !glossyFloor()) return;
  Lanes3 normal, to_eye;
  normalsOf(look.tilt, normal);
  towardsEye(rays.direction, to_eye);
  Lanes shine;
  fill(shine, 0.0F);
  for (std::size_t k = 0; k < scene_.lamps.size(); ++k) {
    addHighlights(k, normal, to_eye, lit, shine);
  }
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) out[k] += look.gloss[k] * shine[k];
  if (!glossyFloor()) return;
  mirror(normal, to_eye, look.gloss, points, rays, mirrors);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) out[k] *= 1.0F - mirrors.share[k];
}

void Shader::radiance(int surface, unsigned members, const PixelRays& rays, const HitPacket& hits,
                      float weight, Lanes& out, Mirrors& mirrors) {
  if (surface == kSky) return sky(rays, out);
  PointPacket points;
  points.members = members;
  points.weight = weight;
  PixelRays own_rays;
  HitPacket own_hits;
  const bool whole = members == kAllLanes;
  if (!whole) {
    select(rays, members, own_rays);
    select(hits, members, own_hits);
  }
  const PixelRays& seen = whole ? rays : own_rays;
  if (surface == kFloor) {
    Stage::resolveFloor(seen, points);
    floor(points, seen, out, mirrors);
  } else {
    stage_.resolvePatch(surface, seen, whole ? hits : own_hits, points);
    solid(surface, points, out);
  }
}

}  // namespace ipm_mapping::sim
