#pragma once
// What the floor is made of, filtered over a pixel's footprint: cells with gaps, grain, wear,
// paint.

#include "ipm_mapping_sim/texture.hpp"

namespace ipm_mapping::sim {

/// The floor under sixteen pixels.
struct FloorLook {
  Lanes albedo;
  Lanes gloss;  ///< share that is not gap
  Lanes2 tilt;  ///< slope of the cell
};

class Floor {
 public:
  Floor(const Scene& scene, TextureSet& textures);

  /// Floor at the points under their pixels.
  void at(const PointPacket& points, FloorLook& look) const;

 private:
  struct Stripe {  ///< any paint: a convex area as distances inside it
    PaintSpec spec;
    Eigen::Vector2f centre, along, across;
    float half_along, half_across;
  };
  /// Where the points lie within their cells.
  struct Places {
    Lanes2 at;     ///< from the cell's lower corner
    Lanes2 own;    ///< share of the pixel on this side of the nearer gap
    Lanes single;  ///< share that is left of the difference between cells
    IntLanes column, row;
  };
  struct Cells {
    Lanes gap, brightness;
    Lanes2 shift, tilt;
  };
  struct Laid {  ///< in the axes along which the floor is laid
    Lanes2 at;
    FootprintPacket pixel;
    Lanes2 wide;  ///< extents of the pixel
  };
  void lay(const PointPacket& points, Laid& laid) const;
  void placesOf(const Laid& laid, Places& places, Lanes& gap) const;
  void staggered(const Laid& laid, IntLanes& row, Lanes& x) const;
  void cellsAt(const Laid& laid, unsigned members, Cells& cells) const;
  [[nodiscard]] float brightness(const Places& places, int k) const;
  void grainAt(const Laid& laid, const Cells& cells, Lanes& grain) const;
  void paint(const PointPacket& points, const Lanes& grain, const Lanes& wear, Lanes& albedo) const;
  static bool stripeShares(const Stripe& stripe, const PointPacket& points, Lanes& shares);
  static void discShares(const Stripe& stripe, const PointPacket& points, Lanes& shares);

  FloorSpec spec_;
  std::uint64_t seed_;
  Eigen::Matrix2f laid_from_world_;
  const Texture* grain_;
  const Texture* blotches_;
  std::vector<Stripe> stripes_;
};

}  // namespace ipm_mapping::sim
