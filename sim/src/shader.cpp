#include "ipm_mapping_sim/shader.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kFloorTexel = 0.01F, kSolidTexel = 0.02F;
constexpr float kGrazingMirror = 0.6F;
constexpr float kVisibleContrast = 0.004F;  // below the sensor's noise

/// Share of the pattern's second reflectance under a pixel.
float patternShare(const Material& material, const SurfacePoint& point) {
  const auto period = static_cast<float>(material.pattern_period);
  const float wide_s = point.pixel.extent(Vector2f::UnitX());
  const float wide_t = point.pixel.extent(Vector2f::UnitY());
  const float s = point.coords.x(), t = point.coords.y();
  switch (material.pattern) {
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

/// Light of a lamp on a surface square to it, relative to the floor straight below the lamp.
float strength(const LampSpec& lamp, const Vector3f& to_lamp, float distance) {
  const auto height = static_cast<float>(lamp.at.z());
  const float falloff = height * height / (distance * distance);
  const float panel = lamp.size > 0.0 ? std::max(0.0F, to_lamp.z()) : 1.0F;
  return static_cast<float>(lamp.energy) * falloff * panel;
}

Vector3f mirrored(const Vector3f& v, const Vector3f& normal) {
  return v - 2.0F * v.dot(normal) * normal;
}

}  // namespace

Shader::Shader(const Scene& scene, const Stage& stage)
    : scene_(scene),
      stage_(stage),
      textures_(static_cast<std::uint64_t>(scene.seed)),
      floor_(scene, textures_),
      floor_map_(stage, scene.lamps, nullptr, kFloorTexel) {
  if (scene.lamps.size() > kMaxLamps) {
    throw ParameterError("scene: lamps are " + std::to_string(scene.lamps.size()) +
                         ", must be at most " + std::to_string(kMaxLamps));
  }
  for (const Patch* patch : stage.patches()) {
    maps_.push_back(std::make_unique<LightMap>(stage, scene.lamps, patch, kSolidTexel));
    grains_.push_back(textures_.get(patch->material.grain));
  }
}

float Shader::sky(const Vector3f& direction) const {
  const float up = std::max(0.0F, direction.z());
  return static_cast<float>(scene_.ceiling) * (0.75F + 0.25F * up);
}

Shader::Lit Shader::light(LightMap& map, const SurfacePoint& point) const {
  LightShares shares = map.at(point);
  const Texel pixel{point.position, point.normal, point.dpdx, point.dpdy};
  Lit lit;
  lit.diffuse =
      static_cast<float>(scene_.ambient) * shares.ambient * (0.8F + 0.2F * point.normal.z());
  for (std::size_t k = 0; k < scene_.lamps.size(); ++k) {
    const LampSpec& lamp = scene_.lamps[k];
    const Vector3f offset = lamp.at.cast<float>() - point.position;
    const float distance = offset.norm(), facing = offset.dot(point.normal) / distance;
    if (facing <= 0.0F) continue;
    if ((shares.steep >> k & 1U) != 0) {
      shares.lamp[k] = lampShare(stage_.tracer(), lamp, pixel, kWholeLamp);
    }
    lit.to_lamp[k] = offset / distance;
    lit.lamp[k] = shares.lamp[k] * strength(lamp, lit.to_lamp[k], distance);
    lit.diffuse += lit.lamp[k] * facing;
  }
  return lit;
}

float Shader::albedoOf(const SurfacePoint& point) const {
  const auto index = static_cast<std::size_t>(point.surface);
  const Material& material = stage_.patches()[index]->material;
  auto albedo = static_cast<float>(material.albedo);
  const float pattern = patternShare(material, point);
  albedo += pattern * (static_cast<float>(material.pattern_albedo) - albedo);
  const Texture* grain = grains_[index];
  const auto contrast = static_cast<float>(material.grain_contrast);
  if (grain != nullptr && contrast * point.weight > kVisibleContrast) {
    const float scale = 1.0F / static_cast<float>(material.grain_size);
    const Vector2f at =
        point.coords * scale + Vector2f::Constant(0.37F * static_cast<float>(index));
    const float value = grain->sample(at, {point.pixel.dx * scale, point.pixel.dy * scale});
    albedo *= 1.0F + contrast * value;
  }
  return std::clamp(albedo, 0.0F, 1.0F);
}

float Shader::solid(const SurfacePoint& point) {
  const Lit lit = light(*maps_[static_cast<std::size_t>(point.surface)], point);
  return albedoOf(point) * lit.diffuse;
}

float Shader::highlights(const Vector3f& normal, const Vector3f& to_eye, const Lit& lit) const {
  float sum = 0.0F;
  for (std::size_t k = 0; k < scene_.lamps.size(); ++k) {
    if (lit.lamp[k] <= 0.0F) continue;
    // Cosine between the normal and the half-way vector of two unit vectors.
    const float half = (normal.dot(lit.to_lamp[k]) + normal.dot(to_eye)) /
                       std::sqrt(2.0F + 2.0F * to_eye.dot(lit.to_lamp[k]));
    // A panel's highlight is wider than a point's by its own angle.
    const auto spread = static_cast<float>(scene_.lamps[k].size / scene_.lamps[k].at.z());
    const auto shine = static_cast<float>(scene_.floor.shininess);
    const float exponent = shine / (1.0F + shine * spread * spread / 8.0F);
    if (exponent * (1.0F - half) > 9.0F) continue;  // under e^-9 of the peak
    sum += lit.lamp[k] * std::pow(half, exponent) * exponent / shine;
  }
  return sum * static_cast<float>(scene_.floor.specular);
}

float Shader::floor(const SurfacePoint& point, const PixelRay& ray, Mirror& mirror) {
  const FloorLook look = floor_.at(point.coords, point.pixel);
  const Lit lit = light(floor_map_, point);
  float radiance = look.albedo * lit.diffuse;
  if (scene_.floor.specular <= 0.0 && !glossyFloor()) return radiance;
  const Vector3f normal = Vector3f(look.tilt.x(), look.tilt.y(), 1.0F).normalized();
  const Vector3f to_eye = -ray.direction.normalized();
  radiance += look.gloss * highlights(normal, to_eye, lit);
  if (!glossyFloor()) return radiance;
  const auto straight = static_cast<float>(scene_.floor.reflection);
  const float grazing = std::pow(1.0F - std::max(0.0F, normal.dot(to_eye)), 5.0F);
  mirror.share = look.gloss * (straight + (1.0F - straight) * kGrazingMirror * grazing);
  // The eye's own mirror image, under the floor where nothing is in the way, sees what the floor
  // mirrors, with footprints that grow along the whole path.
  const float distance = (point.position - ray.origin).norm() / ray.direction.norm();
  const Vector3f direction = mirrored(ray.direction, normal);
  mirror.ray = {point.position - distance * direction, direction, mirrored(ray.ddx, normal),
                mirrored(ray.ddy, normal)};
  return radiance * (1.0F - mirror.share);
}

float Shader::radiance(const SurfacePoint& point, const PixelRay& ray, Mirror& mirror) {
  mirror.share = 0.0F;
  if (point.surface == kSky) return sky(ray.direction);
  return point.surface == kFloor ? floor(point, ray, mirror) : solid(point);
}

}  // namespace ipm_mapping::sim
