#pragma once
// Random textures that are filtered over a pixel's footprint, so that a floor looks the same to
// two cameras wherever both can resolve it, and never flickers.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "ipm_mapping_sim/scene.hpp"

namespace ipm_mapping::sim {

/// Whole number at or below x; std::floor is a library call without SSE4.1.
inline int floorOf(float x) {
  const int whole = static_cast<int>(x);
  return whole - static_cast<int>(static_cast<float>(whole) > x);
}

/// A pixel's parallelogram on a surface: how the surface coordinates (metres) change over one
/// column and over one row.
struct Footprint2 {
  Eigen::Vector2f dx = Eigen::Vector2f::Zero(), dy = Eigen::Vector2f::Zero();

  /// Side of the box with the parallelogram's variance along a unit direction.
  [[nodiscard]] float extent(const Eigen::Vector2f& direction) const {
    const float a = direction.dot(dx), b = direction.dot(dy);
    return std::sqrt(a * a + b * b);
  }
};

/// Periodic zero-mean texture of unit-like amplitude with its mip pyramid.
class Texture {
 public:
  /// kSize x kSize texels of the given kind; the same seed makes the same texels.
  Texture(Grain grain, std::uint64_t seed);

  /// Mean over a footprint around `p`, both in repeats of the texture (1 = the whole square).
  [[nodiscard]] float sample(Eigen::Vector2f p, const Footprint2& pixel) const;

  static constexpr int kLevels = 11;
  static constexpr int kSize = 1 << (kLevels - 1);

 private:
  struct Taps {  ///< a row of samples through the footprint, in repeats; all coordinates positive
    Eigen::Vector2f first, step;
    int count;
  };
  [[nodiscard]] float sum(int level, const Taps& taps) const;

  /// Each level has its first row and column again after its last: no wrap between neighbours.
  std::vector<float> levels_[kLevels];
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
float gapCoverage(float x, float extent, float period, float gap);

/// Share of a box of side `extent` whose centre lies `inside` metres within a straight edge.
float edgeCoverage(float inside, float extent);

}  // namespace ipm_mapping::sim
