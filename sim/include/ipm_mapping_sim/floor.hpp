#pragma once
// What the floor is made of, filtered over a pixel's footprint: cells with gaps, grain, wear,
// paint.

#include "ipm_mapping_sim/texture.hpp"

namespace ipm_mapping::sim {

/// The floor under one pixel.
struct FloorLook {
  float albedo = 0.0F;
  float gloss = 1.0F;                              ///< share that is not gap
  Eigen::Vector2f tilt = Eigen::Vector2f::Zero();  ///< slope of the cell
};

class Floor {
 public:
  Floor(const Scene& scene, TextureSet& textures);

  /// Floor at `p` (world metres) under a pixel's footprint.
  [[nodiscard]] FloorLook at(const Eigen::Vector2f& p, const Footprint2& pixel) const;

 private:
  struct Stripe {  ///< any paint: a convex area as distances inside it
    PaintSpec spec;
    Eigen::Vector2f centre, along, across;
    float half_along, half_across;
  };
  struct Cells {
    float gap = 0.0F, brightness = 1.0F;
    Eigen::Vector2f shift = Eigen::Vector2f::Zero(), tilt = Eigen::Vector2f::Zero();
  };
  [[nodiscard]] Cells cellsAt(const Eigen::Vector2f& laid, const Footprint2& pixel) const;
  [[nodiscard]] float paintShare(const Stripe& stripe, const Eigen::Vector2f& p,
                                 const Footprint2& pixel) const;

  FloorSpec spec_;
  std::uint64_t seed_;
  Eigen::Matrix2f laid_from_world_;
  const Texture* grain_;
  const Texture* blotches_;
  std::vector<Stripe> stripes_;
};

}  // namespace ipm_mapping::sim
