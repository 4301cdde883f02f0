#include "ipm_mapping_sim/light_map.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sim {
namespace {

using Eigen::Vector3f;

constexpr float kLift = 2e-4F;
constexpr float kAmbientReach = 1.2F;
constexpr float kShadowReach = 2.0F;
constexpr float kSteep = 0.2F;

/// Offset in -0.5...0.5 of the k-th of 4 x 4 strata.
Eigen::Vector2f stratum(int k) {
  return {(static_cast<float>(k & 3) + 0.5F) / 4.0F - 0.5F,
          (static_cast<float>(k >> 2) + 0.5F) / 4.0F - 0.5F};
}

/// Pairs surface strata with lamp strata: far from each other in both for each pattern.
int shuffled(int k, int turn) {
  static constexpr int order[16] = {0, 10, 5, 15, 8, 2, 13, 7, 4, 14, 1, 11, 12, 6, 9, 3};
  return order[(k + 5 * std::max(turn, 0)) & 15];
}

void setShadowRay(RayPacket& rays, int k, const Vector3f& origin, const Vector3f& direction) {
  rays.origin.x[k] = origin.x();
  rays.origin.y[k] = origin.y();
  rays.origin.z[k] = origin.z();
  rays.direction.x[k] = direction.x();
  rays.direction.y[k] = direction.y();
  rays.direction.z[k] = direction.z();
}

/// Directions spread over the hemisphere around +z with density cos(angle).
const std::vector<Vector3f>& hemisphere() {
  static const std::vector<Vector3f> directions = [] {
    std::vector<Vector3f> all;
    constexpr int n = 2 * kPacket;
    for (int k = 0; k < n; ++k) {
      const double share = (k + 0.5) / n, angle = 2.399963229728653 * k;
      const double radius = std::sqrt(share);
      all.emplace_back(static_cast<float>(radius * std::cos(angle)),
                       static_cast<float>(radius * std::sin(angle)),
                       static_cast<float>(std::sqrt(1.0 - share)));
    }
    return all;
  }();
  return directions;
}

float ambientShare(const Tracer& tracer, const Texel& texel) {
  const Vector3f tangent = texel.edge_u.normalized(), other = texel.normal.cross(tangent);
  const std::vector<Vector3f>& directions = hemisphere();
  int open = 0;
  for (std::size_t first = 0; first < directions.size(); first += kPacket) {
    RayPacket rays;
    for (std::size_t k = 0; k < kPacket; ++k) {
      const Vector3f& d = directions[first + k];
      const Vector3f along = d.x() * tangent + d.y() * other + d.z() * texel.normal;
      setShadowRay(rays, static_cast<int>(k), texel.centre + kLift * texel.normal, along);
      rays.reach[static_cast<int>(k)] = kAmbientReach;
    }
    open += kPacket - __builtin_popcount(tracer.blocked(rays, Tracer::Bundle::Spread));
  }
  return static_cast<float>(open) / static_cast<float>(directions.size());
}

std::uint64_t tileKey(int i, int j) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32) |
         static_cast<std::uint32_t>(j);
}

}  // namespace

float lampShare(const Tracer& tracer, const LampSpec& lamp, const Texel& area, int turn) {
  RayPacket rays;
  const auto size = static_cast<float>(lamp.size);
  const Vector3f centre = lamp.at.cast<float>();
  const Eigen::Vector2f shift =
      turn < 0 ? Eigen::Vector2f::Zero().eval()
               : Eigen::Vector2f(turn % 2 == 0 ? -0.0625F : 0.0625F, turn < 2 ? -0.0625F : 0.0625F);
  for (int k = 0; k < kPacket; ++k) {
    const Eigen::Vector2f on_area = stratum(k), on_lamp = stratum(shuffled(k, turn)) + shift;
    const Vector3f target = centre + size * Vector3f(on_lamp.x(), on_lamp.y(), 0.0F);
    const Vector3f origin =
        area.centre + on_area.x() * area.edge_u + on_area.y() * area.edge_v + kLift * area.normal;
    setShadowRay(rays, k, origin, target - origin);
    rays.reach[k] = 0.999F;
  }
  return 1.0F -
         static_cast<float>(__builtin_popcount(tracer.blocked(rays, Tracer::Bundle::Alike))) /
             kPacket;
}

LightMap::LightMap(const Stage& stage, Casters casters, const std::vector<LampSpec>& lamps,
                   const Patch* patch, float texel)
    : stage_(stage),
      casters_(casters),
      lamps_(lamps),
      patch_(patch),
      texel_(texel),
      channels_((lamps.size() + 4) / 4 * 4) {
  forget();
  if (patch_ == nullptr) return;
  Eigen::Vector2f longest = Eigen::Vector2f::Zero();
  const auto at = [&](int r, int c) {
    return patch_->points[static_cast<std::size_t>(r * patch_->cols + c)];
  };
  for (int r = 0; r + 1 < patch_->rows; ++r) {
    for (int c = 0; c + 1 < patch_->cols; ++c) {
      longest.x() = std::max(longest.x(), (at(r, c + 1) - at(r, c)).norm());
      longest.y() = std::max(longest.y(), (at(r + 1, c) - at(r, c)).norm());
    }
  }
  per_cell_ = (longest / texel_).array().ceil().max(1.0F);
  lowest_ = 0;
  highest_i_ = (patch_->cols - 1) * static_cast<int>(per_cell_.x()) - 1;
  highest_j_ = (patch_->rows - 1) * static_cast<int>(per_cell_.y()) - 1;
}

void LightMap::forget() {
  tiles_.clear();
  last_ = nullptr;
  if (patch_ != nullptr) return;
  shaded_ = stage_.extent(casters_);
  if (shaded_.isEmpty()) return;
  shaded_ = Eigen::AlignedBox2f(shaded_.min().array() - kShadowReach,
                                shaded_.max().array() + kShadowReach);
}

Texel LightMap::texelAt(int i, int j) const {
  if (patch_ == nullptr) {
    const Vector3f centre((static_cast<float>(i) + 0.5F) * texel_,
                          (static_cast<float>(j) + 0.5F) * texel_, 0.0F);
    return {centre, Vector3f::UnitZ(), texel_ * Vector3f::UnitX(), texel_ * Vector3f::UnitY()};
  }
  const int columns = patch_->cols - 1, rows = patch_->rows - 1;
  const float gu = (static_cast<float>(i) + 0.5F) / per_cell_.x();
  const float gv = (static_cast<float>(j) + 0.5F) / per_cell_.y();
  const int c = std::min(static_cast<int>(gu), columns - 1);
  const int r = std::min(static_cast<int>(gv), rows - 1);
  const float u = gu - static_cast<float>(c), v = gv - static_cast<float>(r);
  const auto first = static_cast<std::size_t>(r * patch_->cols + c);
  const std::size_t above = first + static_cast<std::size_t>(patch_->cols);
  const auto& p = patch_->points;
  // On the triangle itself: a bilinear point would sink into a hollow surface.
  const bool lower = u >= v;
  const Vector3f along = lower ? p[first + 1] - p[first] : p[above + 1] - p[above];
  const Vector3f across = lower ? p[above + 1] - p[first + 1] : p[above] - p[first];
  const Vector3f centre = p[first] + u * along + v * across;
  const auto& n = patch_->normals;
  const Vector3f normal = (1 - v) * ((1 - u) * n[first] + u * n[first + 1]) +
                          v * ((1 - u) * n[above] + u * n[above + 1]);
  return {centre, normal.normalized(), along / per_cell_.x(), across / per_cell_.y()};
}

LightMap::Baked LightMap::bake(const Texel& texel) const {
  Baked out;
  const Tracer& tracer = this->tracer();
  out.covered = stage_.covered(texel.centre, texel.normal, casters_);
  if (out.covered) return out;
  out.shares[0] = ambientShare(tracer, texel);
  for (std::size_t k = 0; k < lamps_.size(); ++k) {
    float& share = out.shares[k + 1];
    share = 1.0F;
    if ((lamps_[k].at.cast<float>() - texel.centre).dot(texel.normal) <= 0.0F) continue;
    share = lampShare(tracer, lamps_[k], texel, kWholeLamp);
    out.mixed[k] = share > 0.0F && share < 1.0F;
    if (!out.mixed[k] || lamps_[k].size == 0.0) continue;
    share = 0.0F;
    for (int turn = 0; turn < 4; ++turn) share += 0.25F * lampShare(tracer, lamps_[k], texel, turn);
  }
  return out;
}

/// A square under a solid would darken its visible neighbours: it takes their mean instead.
void LightMap::uncover(const std::vector<Baked>& baked, int i, int j, float* shares) const {
  const std::size_t n = lamps_.size() + 1;
  const auto at = [&](int di, int dj) -> const Baked& {
    return baked[static_cast<std::size_t>((j + dj) * kBaked + i + di)];
  };
  std::fill(shares, shares + n, 0.0F);
  int count = 0;
  for (int dj = -1; dj <= 1; ++dj) {
    for (int di = -1; di <= 1; ++di) {
      const Baked& other = at(di, dj);
      if (other.covered) continue;
      ++count;
      for (std::size_t k = 0; k < n; ++k) shares[k] += other.shares[k];
    }
  }
  for (std::size_t k = 0; k < n && count > 0; ++k) shares[k] /= static_cast<float>(count);
}

void LightMap::markSteep(const std::vector<Baked>& baked, Tile& tile) const {
  const std::size_t n = lamps_.size() + 1;
  for (int j = 0; j < kTile; ++j) {
    for (int i = 0; i < kTile; ++i) {
      unsigned bits = 0;
      for (std::size_t k = 1; k < n; ++k) {
        float low = 1.0F, high = 0.0F;
        bool mixed = false;
        for (const int corner : {0, 1, kStored, kStored + 1}) {
          const auto at = static_cast<std::size_t>(j * kStored + i + corner);
          low = std::min(low, tile.shares[at * channels_ + k]);
          high = std::max(high, tile.shares[at * channels_ + k]);
          const int row = j + 1 + corner / kStored, column = i + 1 + corner % kStored;
          mixed |= baked[static_cast<std::size_t>(row * kBaked + column)].mixed[k - 1];
        }
        const bool hard = lamps_[k - 1].size == 0.0 && (mixed || high > low);
        if (hard || high - low > kSteep) bits |= 1U << (k - 1);
      }
      tile.steep[static_cast<std::size_t>(j * kTile + i)] = static_cast<std::uint8_t>(bits);
    }
  }
}

/// All squares of a tile and a border around it. Squares beyond the patch repeat its outermost
/// ones, which are always among them.
std::vector<LightMap::Baked> LightMap::bakeSquares(int first_i, int first_j) const {
  std::vector<Baked> baked(static_cast<std::size_t>(kBaked) * kBaked);
  const auto place = [&](int i, int j) -> Baked& {
    return baked[static_cast<std::size_t>((j - first_j) * kBaked + i - first_i)];
  };
  const int low_i = std::max(first_i, lowest_), high_i = std::min(first_i + kBaked - 1, highest_i_);
  const int low_j = std::max(first_j, lowest_), high_j = std::min(first_j + kBaked - 1, highest_j_);
  for (int j = low_j; j <= high_j; ++j) {
    for (int i = low_i; i <= high_i; ++i) place(i, j) = bake(texelAt(i, j));
  }
  for (int j = first_j; j < first_j + kBaked; ++j) {
    for (int i = first_i; i < first_i + kBaked; ++i) {
      place(i, j) = place(std::clamp(i, low_i, high_i), std::clamp(j, low_j, high_j));
    }
  }
  return baked;
}

std::unique_ptr<LightMap::Tile> LightMap::bakeTile(int i, int j) const {
  const std::vector<Baked> baked = bakeSquares(i * kTile - 1, j * kTile - 1);
  const std::size_t n = lamps_.size() + 1;
  auto tile = std::make_unique<Tile>();
  tile->shares.resize(static_cast<std::size_t>(kStored) * kStored * channels_);
  tile->steep.resize(static_cast<std::size_t>(kTile) * kTile);
  for (int row = 0; row < kStored; ++row) {
    for (int column = 0; column < kStored; ++column) {
      const Baked& one = baked[static_cast<std::size_t>((row + 1) * kBaked + column + 1)];
      float* shares = &tile->shares[static_cast<std::size_t>(row * kStored + column) * channels_];
      if (one.covered) {
        uncover(baked, column + 1, row + 1, shares);
      } else {
        std::copy(one.shares, one.shares + n, shares);
      }
    }
  }
  markSteep(baked, *tile);
  return tile;
}

const LightMap::Tile& LightMap::tile(int i, int j) {
  const std::uint64_t key = tileKey(i, j);
  if (last_ != nullptr && key == last_key_) return *last_;
  std::unique_ptr<Tile>& entry = tiles_[key];
  if (!entry) entry = bakeTile(i, j);
  last_key_ = key;
  last_ = entry.get();
  return *entry;
}

/// Shares at a place in squares, blended from the four squares around it.
void LightMap::sampleAt(float x, float y, int lane, LightShares& out) {
  const int i = floorOf(x), j = floorOf(y);
  const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
  const Tile& from = tile(i >> 5, j >> 5);
  const int column = i & (kTile - 1), row = j & (kTile - 1);
  const float* low = &from.shares[static_cast<std::size_t>(row * kStored + column) * channels_];
  const float* high = low + kStored * channels_;
  float shares[kMaxLamps + 4];
  for (std::size_t first = 0; first < channels_; first += 4) {
#pragma omp simd
    for (std::size_t k = first; k < first + 4; ++k) {
      const float bottom = low[k] + u * (low[channels_ + k] - low[k]);
      shares[k] = bottom + v * (high[k] + u * (high[channels_ + k] - high[k]) - bottom);
    }
  }
  out.ambient[lane] = shares[0];
  const unsigned steep = from.steep[static_cast<std::size_t>(row * kTile + column)];
  for (std::size_t k = 0; k < lamps_.size(); ++k) {
    out.lamp[k][lane] = shares[k + 1];
    out.steep[k] |= (steep >> k & 1U) << lane;
  }
}

void LightMap::at(const PointPacket& points, LightShares& out) {
  fill(out.ambient, 1.0F);
  for (std::size_t k = 0; k < lamps_.size(); ++k) fill(out.lamp[k], 1.0F);
  const Lanes2& place = patch_ == nullptr ? points.coords : points.grid;
  const Eigen::Vector2f scale =
      patch_ == nullptr ? Eigen::Vector2f::Constant(1.0F / texel_).eval() : per_cell_;
  forMembers(points.members, [&](int k) {
    const Eigen::Vector2f p(place.x[k], place.y[k]);
    if (patch_ == nullptr && !shaded_.contains(p)) return;
    sampleAt(p.x() * scale.x() - 0.5F, p.y() * scale.y() - 0.5F, k, out);
  });
}

}  // namespace ipm_mapping::sim
