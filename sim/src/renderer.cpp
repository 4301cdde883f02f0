#include "ipm_mapping_sim/renderer.hpp"

#include <algorithm>

namespace ipm_mapping::sim {
namespace {

constexpr int kBlock = 4;
constexpr float kFaintMirror = 0.08F;  // share of light whose mirror image needs no smooth edges
constexpr std::size_t kQueue = 4096;   // parts of pixels that are shaded in one go

/// Place of the k-th of sixteen samples within a pixel: each in its own of 16 columns and rows.
float sampleColumn(int k) { return (static_cast<float>(k) + 0.5F) / kPacket - 0.5F; }
float sampleRow(int k) {
  static constexpr int rows[kPacket] = {6, 13, 1, 10, 4, 15, 8, 2, 12, 0, 7, 14, 3, 9, 5, 11};
  return (static_cast<float>(rows[k]) + 0.5F) / kPacket - 0.5F;
}

/// The sixteen rays of a pixel whose middle one is given, seen from the k-th of them.
SIM_LANES void spread(const PixelRay& middle, float column, float row, PixelRays& rays) {
  const float x = middle.direction.x(), y = middle.direction.y(), z = middle.direction.z();
  const float ax = middle.ddx.x(), ay = middle.ddx.y(), az = middle.ddx.z();
  const float bx = middle.ddy.x(), by = middle.ddy.y(), bz = middle.ddy.z();
  for (int k = 0; k < kPacket; ++k) rays.set(k, middle);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float du = sampleColumn(k) - column, dv = sampleRow(k) - row;
    rays.direction.x[k] = x + du * ax + dv * bx;
    rays.direction.y[k] = y + du * ay + dv * by;
    rays.direction.z[k] = z + du * az + dv * bz;
  }
}

/// The member whose place in the pixel is nearest to the members' mean.
int middleOf(unsigned members) {
  float x = 0.0F, y = 0.0F;
  const auto count = static_cast<float>(__builtin_popcount(members));
  forMembers(members, [&](int k) {
    x += sampleColumn(k) / count;
    y += sampleRow(k) / count;
  });
  int best = 0;
  float nearest = 1e9F;
  forMembers(members, [&](int k) {
    const float distance = std::abs(sampleColumn(k) - x) + std::abs(sampleRow(k) - y);
    if (distance >= nearest) return;
    nearest = distance;
    best = k;
  });
  return best;
}

float largestOf(const Lanes& values, unsigned members) {
  float largest = 0.0F;
  forMembers(members, [&](int k) { largest = std::max(largest, values[k]); });
  return largest;
}

}  // namespace

Renderer::Renderer(const Scene& scene)
    : scene_(scene), stage_(scene_), lens_(cameraModel(scene_.camera)), shader_(scene_, stage_) {
  const std::size_t n = index(0, lens_.height());
  seen_.assign(n, kNothing);
  mirrored_.assign(n, kNothing);
  views_.resize(static_cast<std::size_t>(lens_.height()));
}

PixelRay Renderer::rayOf(int u, int v) const {
  const Lens::Pixel& pixel = lens_.pixel(u, v);
  const View& view = views_[static_cast<std::size_t>(v)];
  return {view.origin, view.turn * Eigen::Vector3f(pixel.at.x(), pixel.at.y(), 1.0F),
          view.turn.leftCols<2>() * pixel.dx, view.turn.leftCols<2>() * pixel.dy};
}

void Renderer::moveTo(double time) {
  if (stage_.moveTo(time)) shader_.forgetMoved();
}

void Renderer::render(const RowPose& T_world_camera, std::vector<float>& radiance) {
  for (int v = 0; v < lens_.height(); ++v) {
    const CameraPose pose = T_world_camera(v);
    views_[static_cast<std::size_t>(v)] = {pose.rotation().cast<float>(),
                                           pose.translation().cast<float>()};
  }
  radiance.assign(seen_.size(), 0.0F);
  std::fill(seen_.begin(), seen_.end(), kNothing);
  std::fill(mirrored_.begin(), mirrored_.end(), kNothing);
  for (int v = 0; v < lens_.height(); v += kBlock) {
    for (int u = 0; u < lens_.width(); u += kBlock) renderBlock(u, v, radiance);
  }
  smoothEdges(radiance);
}

// --- every pixel's middle
// -------------------------------------------------------------------------

/// Rays of a 4 x 4 block; a bit for each that exists.
unsigned Renderer::setBlock(int u0, int v0, PixelRays& rays) const {
  unsigned active = 0;
  for (int k = 0; k < kPacket; ++k) {
    const int u = u0 + k % kBlock, v = v0 + k / kBlock;
    if (u >= lens_.width() || v >= lens_.height() || !lens_.pixel(u, v).seen) continue;
    rays.set(k, rayOf(u, v));
    active |= 1U << k;
  }
  return active;
}

void Renderer::renderBlock(int u0, int v0, std::vector<float>& radiance) {
  PixelRays rays;
  const unsigned active = setBlock(u0, v0, rays);
  if (active == 0) return;
  rays.reachFloor();
  HitPacket hits;
  stage_.tracer().nearest(rays, active, hits);
  IntLanes surfaces;
  Stage::surfacesOf(rays, hits, surfaces);
  std::size_t pixels[kPacket];
  for (int k = 0; k < kPacket; ++k) pixels[k] = index(u0 + k % kBlock, v0 + k / kBlock);
  forGroups(surfaces, active, [&](int surface, unsigned members) {
    Lanes light;
    Mirrors mirrors;
    shader_.radiance(surface, members, rays, hits, 1.0F, light, mirrors);
    forMembers(members, [&](int k) {
      seen_[pixels[k]] = surface;
      radiance[pixels[k]] = light[k];
    });
    if (surface == kFloor && shader_.glossyFloor()) addMirrors(pixels, members, mirrors, radiance);
  });
}

void Renderer::addMirrors(const std::size_t* pixels, unsigned members, Mirrors& mirrors,
                          std::vector<float>& radiance) {
  unsigned active = 0;
  forMembers(members,
             [&](int k) { active |= static_cast<unsigned>(mirrors.share[k] > 0.0F) << k; });
  if (active == 0) return;
  mirrors.rays.reachFloor();
  HitPacket hits;
  stage_.tracer().nearest(mirrors.rays, active, hits);
  IntLanes surfaces;
  Stage::surfacesOf(mirrors.rays, hits, surfaces);
  forGroups(surfaces, active, [&](int surface, unsigned group) {
    Lanes light;
    Mirrors none;
    const float weight = largestOf(mirrors.share, group);
    shader_.radiance(surface, group, mirrors.rays, hits, weight, light, none);
    forMembers(group, [&](int k) {
      if (mirrors.share[k] > kFaintMirror) mirrored_[pixels[k]] = surface;
      radiance[pixels[k]] += mirrors.share[k] * light[k];
    });
  });
}

// --- pixels in which surfaces meet
// -----------------------------------------------------------------

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
      if (seen_[index(u, v)] == kNothing || !isEdge(u, v)) continue;
      radiance[index(u, v)] = 0.0F;
      queuePixel(u, v);
      if (parts_.size() > kQueue) shadeQueues(radiance);
    }
  }
  shadeQueues(radiance);
}

void Renderer::queuePixel(int u, int v) {
  PixelRays rays;
  spread(rayOf(u, v), 0.0F, 0.0F, rays);
  Part whole;
  whole.share = 1.0F;
  whole.pixel = index(u, v);
  queueParts(rays, kAllLanes, whole, parts_);
}

/// The mirrored rays of a part of a glossy floor, spread like the part itself; a faint mirror's
/// middle one stands for all.
void Renderer::queueMirror(const Part& part, const PixelRay& mirror, float share) {
  PixelRays rays;
  const unsigned members = share > kFaintMirror ? part.members : 1U << part.middle;
  spread(mirror, sampleColumn(part.middle), sampleRow(part.middle), rays);
  Part whole = part;
  whole.weight = share;
  queueParts(rays, members, whole, mirrored_parts_);
}

/// Traces the rays of `whole` and queues a part for each surface that they meet.
void Renderer::queueParts(const PixelRays& all, unsigned members, const Part& whole,
                          Parts& queue) const {
  PixelRays rays = all;
  rays.reachFloor();
  HitPacket hits;
  stage_.tracer().nearest(rays, members, hits);
  IntLanes surfaces;
  Stage::surfacesOf(rays, hits, surfaces);
  const auto count = static_cast<float>(__builtin_popcount(members));
  forGroups(surfaces, members, [&](int surface, unsigned group) {
    Part part = whole;
    part.middle = middleOf(group);
    part.ray = rays.get(part.middle);
    part.hit = hits.get(part.middle);
    part.surface = surface;
    part.members = group;
    part.share *= static_cast<float>(__builtin_popcount(group)) / count;
    queue.push_back(part);
  });
}

void Renderer::shadeQueues(std::vector<float>& radiance) {
  shadeParts(parts_, radiance);
  shadeParts(mirrored_parts_, radiance);
  parts_.clear();
  mirrored_parts_.clear();
}

/// Shades parts of the same surface together, sixteen at once.
void Renderer::shadeParts(const Parts& parts, std::vector<float>& radiance) {
  order_.clear();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto surface = static_cast<std::uint64_t>(parts[i].surface - kNothing);
    order_.push_back(surface << 32 | i);
  }
  std::sort(order_.begin(), order_.end());
  for (std::size_t i = 0; i < order_.size();) i = shadePacket(parts, i, radiance);
}

/// Shades the parts from the first-th in order on that share its surface; returns the next one.
std::size_t Renderer::shadePacket(const Parts& parts, std::size_t first,
                                  std::vector<float>& radiance) {
  const auto part = [&](int k) -> const Part& {
    return parts[order_[first + static_cast<std::size_t>(k)] & 0xFFFFFFFFU];
  };
  PixelRays rays;
  HitPacket hits;
  float weight = 0.0F;
  int count = 0;
  const int surface = part(0).surface;
  for (; count < kPacket && first + static_cast<std::size_t>(count) < order_.size(); ++count) {
    if (part(count).surface != surface) break;
    rays.set(count, part(count).ray);
    hits.set(count, part(count).hit);
    weight = std::max(weight, part(count).weight);
  }
  const unsigned members = (1U << count) - 1U;
  Lanes light;
  Mirrors mirrors;
  shader_.radiance(surface, members, rays, hits, weight, light, mirrors);
  const bool mirroring = surface == kFloor && shader_.glossyFloor();
  for (int k = 0; k < count; ++k) {
    radiance[part(k).pixel] += part(k).share * part(k).weight * light[k];
    if (!mirroring || mirrors.share[k] <= 0.0F) continue;
    queueMirror(part(k), mirrors.rays.get(k), mirrors.share[k]);
  }
  return first + static_cast<std::size_t>(count);
}

}  // namespace ipm_mapping::sim
