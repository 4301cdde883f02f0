#include "ipm_mapping_sim/tracer.hpp"

#include <cstring>
#include <stdexcept>

namespace ipm_mapping::sim {
namespace {

void writePoints(const Patch& patch, void* buffer) {
  auto* vertices = static_cast<float*>(buffer);
  for (const Eigen::Vector3f& p : patch.points) {
    for (int k = 0; k < 3; ++k) *vertices++ = p[k];
  }
}

void attach(RTCDevice device, RTCScene scene, const Patch& patch, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  writePoints(patch, rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             3 * sizeof(float), patch.points.size()));
  const int triangles = patch.triangleCount();
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), static_cast<std::size_t>(triangles)));
  for (int prim = 0; prim < triangles; ++prim) {
    const Eigen::Vector3i corners = patch.triangle(prim);
    for (int k = 0; k < 3; ++k) *indices++ = static_cast<unsigned>(corners[k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

template <class Packet>
void fill(const RayPacket& rays, Packet& packet) {
  const auto copy = [](float* to, const Lanes& from) { std::memcpy(to, from.v, sizeof from.v); };
  copy(packet.org_x, rays.origin.x);
  copy(packet.org_y, rays.origin.y);
  copy(packet.org_z, rays.origin.z);
  copy(packet.dir_x, rays.direction.x);
  copy(packet.dir_y, rays.direction.y);
  copy(packet.dir_z, rays.direction.z);
  copy(packet.tfar, rays.reach);
  for (int k = 0; k < kPacket; ++k) {
    packet.tnear[k] = packet.time[k] = 0.0F;
    packet.mask[k] = ~0U;
    packet.id[k] = static_cast<unsigned>(k);
    packet.flags[k] = 0;
  }
}

RTCIntersectContext contextFor(Tracer::Bundle bundle) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (bundle == Tracer::Bundle::Alike) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

}  // namespace

Tracer::Tracer(const std::vector<const Patch*>& patches) {
  // One thread keeps the order in which the hierarchy is built, and with it the bytes, fixed.
  device_ = rtcNewDevice("threads=1,set_affinity=0");
  if (device_ == nullptr) throw std::runtime_error("cannot start the ray tracer");
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (patches[i] != nullptr) attach(device_, scene_, *patches[i], static_cast<unsigned>(i));
  }
  commit();
}

void Tracer::update(std::size_t index, const Patch& patch) {
  RTCGeometry geometry = rtcGetGeometry(scene_, static_cast<unsigned>(index));
  writePoints(patch, rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
}

void Tracer::commit() { rtcCommitScene(scene_); }

Tracer::~Tracer() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

void Tracer::nearest(const RayPacket& rays, unsigned active, HitPacket& hits) const {
  RTCIntersectContext context = contextFor(Bundle::Alike);
  RTCRayHit16 packet;
  fill(rays, packet.ray);
  alignas(64) int valid[kPacket];
  for (int k = 0; k < kPacket; ++k) {
    packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    valid[k] = contains(active, k) ? -1 : 0;
  }
  rtcIntersect16(valid, scene_, &context, &packet);
  for (int k = 0; k < kPacket; ++k) {
    hits.patch[k] = static_cast<int>(packet.hit.geomID[k]);  // RTC_INVALID_GEOMETRY_ID is -1
    hits.prim[k] = static_cast<int>(packet.hit.primID[k]);
    hits.u[k] = packet.hit.u[k];
    hits.v[k] = packet.hit.v[k];
    hits.distance[k] = packet.ray.tfar[k];
  }
}

Hit Tracer::nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                    float reach) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray = {
      origin.x(), origin.y(), origin.z(), 0.0F, direction.x(), direction.y(), direction.z(), 0.0F,
      reach,      ~0U,        0U,         0U};
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {static_cast<int>(ray.hit.geomID), static_cast<int>(ray.hit.primID), ray.hit.u, ray.hit.v,
          ray.ray.tfar};
}

unsigned Tracer::blocked(const RayPacket& rays, Bundle bundle) const {
  RTCIntersectContext context = contextFor(bundle);
  RTCRay16 packet;
  fill(rays, packet);
  alignas(64) int valid[kPacket];
  for (int& lane : valid) lane = -1;
  rtcOccluded16(valid, scene_, &context, &packet);
  unsigned bits = 0;
  for (int k = 0; k < kPacket; ++k) bits |= static_cast<unsigned>(packet.tfar[k] < 0.0F) << k;
  return bits;
}

}  // namespace ipm_mapping::sim
