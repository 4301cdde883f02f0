#pragma once
// Random textures that are filtered over a pixel's footprint, so that a floor looks the same to
// two cameras wherever both can resolve it, and never flickers.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "ipm_mapping_sim/rays.hpp"
#include "ipm_mapping_sim/scene.hpp"

namespace ipm_mapping::sim {

/// Side of the box with a pixel's parallelogram's variance along a unit direction.
inline float extentAlong(float along_dx, float along_dy) {
  return std::sqrt(along_dx * along_dx + along_dy * along_dy);
}

/// Periodic zero-mean texture of unit-like amplitude with its mip pyramid.
class Texture {
 public:
  /// kSize x kSize texels of the given kind; the same seed makes the same texels.
  Texture(Grain grain, std::uint64_t seed);

  /// Means over footprints around `p`; p and the footprints are divided by `repeat`, the side of
  /// the square that the texture covers.
  void sample(const Lanes2& p, const FootprintPacket& pixel, float repeat, Lanes& out) const;

  static constexpr int kLevels = 11;
  static constexpr int kSize = 1 << (kLevels - 1);

 private:
  /// Rows of samples through the footprints, in repeats; all coordinates positive.
  struct Taps {
    Lanes2 first, step;
    IntLanes count, level;
    Lanes finer;  ///< share of `level`; the rest is of the next coarser one
    int longest = 1;
    bool blends = false;
  };
  void place(const Lanes2& p, const FootprintPacket& pixel, float repeat, Taps& taps) const;
  void addTap(const Taps& taps, int tap, int coarser, Lanes& sum) const;

  /// All levels one after the other, each with its first row and column again after its last: no
  /// wrap between neighbours.
  std::vector<float> texels_;
  std::int32_t first_[kLevels] = {};
  int smooth_level_ = 0;  ///< finest level that is worth reading
};

/// The textures of a scene, each made once.
class TextureSet {
 public:
  explicit TextureSet(std::uint64_t seed) : seed_(seed) {}
  /// Null for Grain::None.
  const Texture* get(Grain grain);

 private:
  std::uint64_t seed_;
  std::unique_ptr<Texture> textures_[enum_names<Grain>.size()];
};

/// Share of a box of side `extent` around x that lies in the gaps of width `gap` centred on the
/// multiples of `period`.
inline float gapCoverage(float x, float extent, float period, float gap) {
  const float box = std::max(extent, 1e-6F), per_metre = 1.0F / period;
  const auto integral = [&](float at) {  // of the gaps' indicator from 0 to `at`
    const float shifted = at + 0.5F * gap;
    const auto cell = static_cast<float>(floorOf(shifted * per_metre));
    return cell * gap + std::min(shifted - cell * period, gap);
  };
  return (integral(x + 0.5F * box) - integral(x - 0.5F * box)) / box;
}

/// Share of a box of side `extent` whose centre lies `inside` metres within a straight edge.
inline float edgeCoverage(float inside, float extent) {
  return std::min(std::max(0.5F + inside / std::max(extent, 1e-6F), 0.0F), 1.0F);
}

}  // namespace ipm_mapping::sim
