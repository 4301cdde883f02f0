#pragma once
// Ray queries against the solids of a scene (Embree). The floor is not in here: it is the plane
// z = 0 and met by arithmetic.

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping_sim/patch.hpp"

namespace ipm_mapping::sim {

constexpr int kPacket = 16;

/// Sixteen rays; a lane takes part where active is -1.
struct alignas(64) RayPacket {
  int active[kPacket];
  Eigen::Vector3f origin[kPacket], direction[kPacket];
  float reach[kPacket];
};

/// What a ray met: a triangle of a patch at `distance` directions; patch < 0 is nothing.
struct Hit {
  int patch = -1, prim = 0;
  float u = 0.0F, v = 0.0F, distance = 0.0F;
};

class Tracer {
 public:
  explicit Tracer(const std::vector<const Patch*>& patches);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Nearest hit of each active ray within its reach.
  void nearest(const RayPacket& rays, Hit* hits) const;
  [[nodiscard]] Hit nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                            float reach) const;
  /// Bit k is set where active ray k meets anything within its reach.
  [[nodiscard]] unsigned blocked(const RayPacket& rays) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace ipm_mapping::sim
