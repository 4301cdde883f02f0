#pragma once
// Light that reaches a surface, found once for each small square of it and kept until forget():
// lamps and most solids do not move. Where a shadow's edge crosses a square, the square says so and
// the pixel is to ask the ray tracer itself.

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "ipm_mapping_sim/stage.hpp"

namespace ipm_mapping::sim {

constexpr int kMaxLamps = 8;

/// Shares of light in 0...1 at sixteen points; `steep` has a bit for each point at which a lamp's
/// share must be asked for again with lampShare().
struct LightShares {
  Lanes ambient;
  Lanes lamp[kMaxLamps];
  unsigned steep[kMaxLamps] = {};
};

/// A square of a surface: its centre and its edges.
struct Texel {
  Eigen::Vector3f centre, normal, edge_u, edge_v;
};

/// Share of a lamp that reaches the points of a parallelogram: sixteen rays, each from another
/// part of the parallelogram to another part of the lamp. Turns 0...3 together ask 64 parts of it.
constexpr int kWholeLamp = -1;
float lampShare(const Tracer& tracer, const LampSpec& lamp, const Texel& area, int turn);

class LightMap {
 public:
  /// What `casters` leave of the light on one patch, or on the floor with patch == nullptr; `texel`
  /// metres a square.
  LightMap(const Stage& stage, Casters casters, const std::vector<LampSpec>& lamps,
           const Patch* patch, float texel);

  /// Something has moved.
  void forget();
  [[nodiscard]] const Tracer& tracer() const { return stage_.tracer(casters_); }

  /// Shares at the members of a packet; the other lanes see all light.
  void at(const PointPacket& points, LightShares& out);

 private:
  static constexpr int kTile = 32, kStored = kTile + 1, kBaked = kTile + 3;
  static constexpr int kNoLimit[2] = {-(1 << 30), 1 << 30};
  struct Tile {
    std::vector<float> shares;        ///< kStored^2 squares x channels
    std::vector<std::uint8_t> steep;  ///< kTile^2 bits between four squares
  };
  struct Baked {
    float shares[kMaxLamps + 1];
    bool covered = false, mixed[kMaxLamps] = {};
  };

  const Tile& tile(int i, int j);
  void sampleAt(float x, float y, int lane, LightShares& out);
  [[nodiscard]] std::vector<Baked> bakeSquares(int first_i, int first_j) const;
  [[nodiscard]] std::unique_ptr<Tile> bakeTile(int i, int j) const;
  [[nodiscard]] Texel texelAt(int i, int j) const;
  [[nodiscard]] Baked bake(const Texel& texel) const;
  void uncover(const std::vector<Baked>& baked, int i, int j, float* shares) const;
  void markSteep(const std::vector<Baked>& baked, Tile& tile) const;

  const Stage& stage_;
  Casters casters_;
  const std::vector<LampSpec>& lamps_;
  const Patch* patch_;
  float texel_;
  std::size_t channels_;        ///< a square's shares: ambient, lamps, and what fills up to fours
  Eigen::AlignedBox2f shaded_;  ///< part of the floor that solids can darken
  Eigen::Vector2f per_cell_ = Eigen::Vector2f::Ones();  ///< squares a cell of the patch's grid
  int lowest_ = kNoLimit[0], highest_i_ = kNoLimit[1], highest_j_ = kNoLimit[1];  ///< squares
  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
  std::uint64_t last_key_ = 0;
  const Tile* last_ = nullptr;
};

}  // namespace ipm_mapping::sim
