#include "ipm_mapping_sim/renderer.hpp"

#include <algorithm>

namespace ipm_mapping::sim {
namespace {

constexpr int kBlock = 4;
constexpr int kNothing = -3;

/// Calls body(u, v, lane) for the pixels of a 4 x 4 block that are inside the image.
template <class Body>
void forBlock(int u0, int v0, int width, int height, Body&& body) {
  for (int k = 0; k < kPacket; ++k) {
    const int u = u0 + k % kBlock, v = v0 + k / kBlock;
    if (u < width && v < height) body(u, v, k);
  }
}

/// Place of the k-th of sixteen samples within a pixel: each in its own of 16 columns and rows.
float sampleColumn(int k) { return (static_cast<float>(k) + 0.5F) / kPacket - 0.5F; }
float sampleRow(int k) {
  static constexpr int rows[kPacket] = {6, 13, 1, 10, 4, 15, 8, 2, 12, 0, 7, 14, 3, 9, 5, 11};
  return (static_cast<float>(rows[k]) + 0.5F) / kPacket - 0.5F;
}

void setRay(RayPacket& packet, int k, const PixelRay& ray) {
  packet.active[k] = -1;
  packet.origin[k] = ray.origin;
  packet.direction[k] = ray.direction;
  packet.reach[k] = Stage::reach(ray.origin, ray.direction);
}

RayPacket emptyPacket() {
  RayPacket packet;
  for (int k = 0; k < kPacket; ++k) {
    packet.active[k] = 0;
    packet.origin[k] = Eigen::Vector3f::Zero();
    packet.direction[k] = Eigen::Vector3f::UnitZ();
    packet.reach[k] = 0.0F;
  }
  return packet;
}

/// Splits sixteen hits by what they met: calls body(surface, members) for each surface.
template <class Body>
void forGroups(const int* surfaces, unsigned members, Body&& body) {
  while (members != 0) {
    const int surface = surfaces[__builtin_ctz(members)];
    unsigned group = 0;
    for (int k = 0; k < kPacket; ++k) {
      if ((members >> k & 1U) != 0 && surfaces[k] == surface) group |= 1U << k;
    }
    members &= ~group;
    body(surface, group);
  }
}

/// The member whose place in the pixel is nearest to the members' mean.
int middleOf(unsigned members) {
  float x = 0.0F, y = 0.0F;
  const auto count = static_cast<float>(__builtin_popcount(members));
  for (int k = 0; k < kPacket; ++k) {
    if ((members >> k & 1U) == 0) continue;
    x += sampleColumn(k) / count;
    y += sampleRow(k) / count;
  }
  int best = 0;
  float nearest = 1e9F;
  for (int k = 0; k < kPacket; ++k) {
    const float distance = std::abs(sampleColumn(k) - x) + std::abs(sampleRow(k) - y);
    if ((members >> k & 1U) == 0 || distance >= nearest) continue;
    nearest = distance;
    best = k;
  }
  return best;
}

}  // namespace

Renderer::Renderer(const Scene& scene)
    : scene_(scene), stage_(scene_), lens_(cameraModel(scene_.camera)), shader_(scene_, stage_) {
  const std::size_t n = index(0, lens_.height());
  seen_.assign(n, kNothing);
  mirrored_.assign(n, kNothing);
  views_.resize(static_cast<std::size_t>(lens_.height()));
}

PixelRay Renderer::rayOf(int u, int v, float du, float dv) const {
  const Lens::Pixel& pixel = lens_.pixel(u, v);
  const View& view = views_[static_cast<std::size_t>(v)];
  const Eigen::Vector2f at = pixel.at + du * pixel.dx + dv * pixel.dy;
  return {view.origin, view.turn * Eigen::Vector3f(at.x(), at.y(), 1.0F),
          view.turn.leftCols<2>() * pixel.dx, view.turn.leftCols<2>() * pixel.dy};
}

void Renderer::render(const RowPose& T_world_camera, std::vector<float>& radiance) {
  for (int v = 0; v < lens_.height(); ++v) {
    const CameraPose pose = T_world_camera(v);
    views_[static_cast<std::size_t>(v)] = {pose.rotation().cast<float>(),
                                           pose.translation().cast<float>()};
  }
  radiance.assign(seen_.size(), 0.0F);
  for (int v = 0; v < lens_.height(); v += kBlock) {
    for (int u = 0; u < lens_.width(); u += kBlock) renderBlock(u, v, radiance);
  }
  smoothEdges(radiance);
}

void Renderer::renderBlock(int u0, int v0, std::vector<float>& radiance) {
  RayPacket packet = emptyPacket();
  PixelRay rays[kPacket];
  Mirror mirrors[kPacket];
  const auto forPixels = [&](auto&& body) {
    forBlock(u0, v0, lens_.width(), lens_.height(), body);
  };
  forPixels([&](int u, int v, int k) {
    if (!lens_.pixel(u, v).seen) return;
    rays[k] = rayOf(u, v, 0, 0);
    setRay(packet, k, rays[k]);
  });
  Hit hits[kPacket];
  stage_.tracer().nearest(packet, hits);
  forPixels([&](int u, int v, int k) {
    int& seen = seen_[index(u, v)];
    seen = kNothing;
    if (packet.active[k] == 0) return;
    const SurfacePoint point = stage_.resolve(rays[k], hits[k]);
    seen = point.surface;
    radiance[index(u, v)] = shader_.radiance(point, rays[k], mirrors[k]);
  });
  if (shader_.glossyFloor()) addMirrors(u0, v0, mirrors, radiance);
}

void Renderer::addMirrors(int u0, int v0, const Mirror* mirrors, std::vector<float>& radiance) {
  RayPacket packet = emptyPacket();
  int any = 0;
  for (int k = 0; k < kPacket; ++k) {
    if (mirrors[k].share <= 0.0F) continue;
    setRay(packet, k, mirrors[k].ray);
    any = 1;
  }
  Hit hits[kPacket];
  if (any != 0) stage_.tracer().nearest(packet, hits);
  forBlock(u0, v0, lens_.width(), lens_.height(), [&](int u, int v, int k) {
    const std::size_t i = index(u, v);
    mirrored_[i] = kNothing;
    if (packet.active[k] == 0) return;
    SurfacePoint point = stage_.resolve(mirrors[k].ray, hits[k]);
    point.weight = mirrors[k].share;
    mirrored_[i] = point.surface;
    Mirror none;
    radiance[i] += mirrors[k].share * shader_.radiance(point, mirrors[k].ray, none);
  });
}

bool Renderer::isEdge(int u, int v) const {
  const std::size_t i = index(u, v);
  for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    if (u + du < 0 || u + du >= lens_.width() || v + dv < 0 || v + dv >= lens_.height()) continue;
    const std::size_t other = index(u + du, v + dv);
    if (seen_[other] == kNothing) continue;
    if (seen_[other] != seen_[i]) return true;
    // A mirror image ends softly in a gap, where the floor mirrors nothing.
    const bool both = mirrored_[other] != kNothing && mirrored_[i] != kNothing;
    if (both && mirrored_[other] != mirrored_[i]) return true;
  }
  return false;
}

void Renderer::smoothEdges(std::vector<float>& radiance) {
  for (int v = 0; v < lens_.height(); ++v) {
    for (int u = 0; u < lens_.width(); ++u) {
      if (seen_[index(u, v)] != kNothing && isEdge(u, v)) radiance[index(u, v)] = smoothed(u, v);
    }
  }
}

float Renderer::smoothed(int u, int v) {
  RayPacket packet;
  PixelRay rays[kPacket];
  for (int k = 0; k < kPacket; ++k) {
    rays[k] = rayOf(u, v, sampleColumn(k), sampleRow(k));
    setRay(packet, k, rays[k]);
  }
  Hit hits[kPacket];
  stage_.tracer().nearest(packet, hits);
  int surfaces[kPacket];
  for (int k = 0; k < kPacket; ++k) surfaces[k] = Stage::surfaceOf(hits[k], rays[k].direction);
  float sum = 0.0F;
  forGroups(surfaces, 0xFFFFU, [&](int, unsigned group) {
    sum += shadeGroup(rays, hits, group) * static_cast<float>(__builtin_popcount(group));
  });
  return sum / kPacket;
}

float Renderer::shadeGroup(const PixelRay* rays, const Hit* hits, unsigned members) {
  const int middle = middleOf(members);
  Mirror mirror;
  const SurfacePoint point = stage_.resolve(rays[middle], hits[middle]);
  float radiance = shader_.radiance(point, rays[middle], mirror);
  if (mirror.share <= 0.0F) return radiance;
  PixelRay mirrors[kPacket];
  for (int k = 0; k < kPacket; ++k) {
    if ((members >> k & 1U) == 0) continue;
    const float du = sampleColumn(k) - sampleColumn(middle), dv = sampleRow(k) - sampleRow(middle);
    mirrors[k] = mirror.ray;
    mirrors[k].direction += du * mirror.ray.ddx + dv * mirror.ray.ddy;
  }
  return radiance + mirror.share * mirroredLight(mirrors, members);
}

float Renderer::mirroredLight(const PixelRay* rays, unsigned members) {
  RayPacket packet = emptyPacket();
  for (int k = 0; k < kPacket; ++k) {
    if ((members >> k & 1U) != 0) setRay(packet, k, rays[k]);
  }
  Hit hits[kPacket];
  stage_.tracer().nearest(packet, hits);
  int surfaces[kPacket];
  for (int k = 0; k < kPacket; ++k) surfaces[k] = Stage::surfaceOf(hits[k], packet.direction[k]);
  float sum = 0.0F;
  forGroups(surfaces, members, [&](int, unsigned group) {
    Mirror none;
    const int middle = middleOf(group);
    sum += shader_.radiance(stage_.resolve(rays[middle], hits[middle]), rays[middle], none) *
           static_cast<float>(__builtin_popcount(group));
  });
  return sum / static_cast<float>(__builtin_popcount(members));
}

}  // namespace ipm_mapping::sim
