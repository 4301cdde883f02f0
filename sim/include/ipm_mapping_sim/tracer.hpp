#pragma once
// Ray queries against the solids of a scene (Embree). The floor is not in here: it is the plane
// z = 0 and met by arithmetic.

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping_sim/patch.hpp"
#include "ipm_mapping_sim/rays.hpp"

namespace ipm_mapping::sim {

class Tracer {
 public:
  /// Surfaces keep their index as their number; those that are nullptr are left out.
  explicit Tracer(const std::vector<const Patch*>& patches);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Takes over where the points of a patch are now; counts with the next commit().
  void update(std::size_t index, const Patch& patch);
  void commit();

  /// Nearest hit of each ray in `active` within its reach; patch is -1 where there is none.
  void nearest(const RayPacket& rays, unsigned active, HitPacket& hits) const;
  [[nodiscard]] Hit nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                            float reach) const;
  /// Whether rays go much the same way: only a hint, for speed.
  enum class Bundle { Alike, Spread };
  /// Bit k is set where ray k meets anything within its reach.
  [[nodiscard]] unsigned blocked(const RayPacket& rays, Bundle bundle) const;

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

}  // namespace ipm_mapping::sim
