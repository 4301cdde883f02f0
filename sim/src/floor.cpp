#include "ipm_mapping_sim/floor.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping_sim/random.hpp"

namespace ipm_mapping::sim {
namespace {

using Eigen::Vector2f;

/// Sums of a packet's member values, to see whether there are any.
inline bool anyPositive(const Lanes& values) {
  int count = 0;
#pragma omp simd reduction(+ : count)
  for (int k = 0; k < kPacket; ++k) count += static_cast<int>(values[k] > 0.0F);
  return count > 0;
}

/// A pixel's extent along a unit direction.
inline float extentOf(const FootprintPacket& pixel, int k, float x, float y) {
  return extentAlong(x * pixel.dx.x[k] + y * pixel.dx.y[k], x * pixel.dy.x[k] + y * pixel.dy.y[k]);
}

}  // namespace

Floor::Floor(const Scene& scene, TextureSet& textures)
    : spec_(scene.floor),
      seed_(hashOf(static_cast<std::uint64_t>(scene.seed),
                   static_cast<std::uint64_t>(Stream::Texture))),
      grain_(textures.get(spec_.grain)),
      blotches_(spec_.blotch_contrast > 0.0 ? textures.get(Grain::Clouds) : nullptr) {
  const auto c = static_cast<float>(std::cos(spec_.yaw)),
             s = static_cast<float>(std::sin(spec_.yaw));
  laid_from_world_ << c, s, -s, c;
  for (const PaintSpec& paint : scene.paint) {
    Stripe stripe{paint,
                  Vector2f(static_cast<float>(paint.x), static_cast<float>(paint.y)),
                  {},
                  {},
                  static_cast<float>(paint.lx / 2),
                  static_cast<float>(paint.ly / 2)};
    stripe.along = {static_cast<float>(std::cos(paint.yaw)),
                    static_cast<float>(std::sin(paint.yaw))};
    if (paint.kind == PaintKind::Line) {
      stripe.centre = (0.5 * (paint.from + paint.to)).cast<float>();
      stripe.along = (paint.to - paint.from).normalized().cast<float>();
      stripe.half_along = static_cast<float>((paint.to - paint.from).norm() / 2);
      stripe.half_across = static_cast<float>(paint.width / 2);
    }
    stripe.across = {-stripe.along.y(), stripe.along.x()};
    stripes_.push_back(stripe);
  }
}

SIM_LANES void Floor::lay(const PointPacket& points, Laid& laid) const {
  const float c = laid_from_world_(0, 0), s = laid_from_world_(0, 1);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float x = points.coords.x[k], y = points.coords.y[k];
    laid.at.x[k] = c * x + s * y;
    laid.at.y[k] = c * y - s * x;
    const float ax = points.pixel.dx.x[k], ay = points.pixel.dx.y[k];
    const float bx = points.pixel.dy.x[k], by = points.pixel.dy.y[k];
    laid.pixel.dx.x[k] = c * ax + s * ay;
    laid.pixel.dx.y[k] = c * ay - s * ax;
    laid.pixel.dy.x[k] = c * bx + s * by;
    laid.pixel.dy.y[k] = c * by - s * bx;
    laid.wide.x[k] = extentAlong(laid.pixel.dx.x[k], laid.pixel.dy.x[k]);
    laid.wide.y[k] = extentAlong(laid.pixel.dx.y[k], laid.pixel.dy.y[k]);
  }
}

/// Rows of the points and their x, moved by their row's random stagger.
void Floor::staggered(const Laid& laid, IntLanes& row, Lanes& x) const {
  const auto size = static_cast<float>(spec_.cell_y);
  for (int k = 0; k < kPacket; ++k) row[k] = floorOf(laid.at.y[k] / size);
  x = laid.at.x;
  if (spec_.stagger <= 0.0) return;
  const auto most = static_cast<float>(spec_.stagger * spec_.cell_x);
  float shift = 0.0F;
  for (int k = 0; k < kPacket; ++k) {
    if (k == 0 || row[k] != row[k - 1]) shift = most * unitFloat(cellHash(seed_, row[k], 0x5747));
    x[k] += shift;
  }
}

SIM_LANES void Floor::placesOf(const Laid& laid, Places& places, Lanes& gap) const {
  const auto size_x = static_cast<float>(spec_.cell_x), size_y = static_cast<float>(spec_.cell_y);
  const auto wide = static_cast<float>(spec_.gap);
  Lanes x;
  IntLanes row;
  staggered(laid, row, x);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const int column = floorOf(x[k] / size_x);
    const float in_x = x[k] - static_cast<float>(column) * size_x;
    const float in_y = laid.at.y[k] - static_cast<float>(row[k]) * size_y;
    const float edge_x = std::min(in_x, size_x - in_x), edge_y = std::min(in_y, size_y - in_y);
    const float wide_x = laid.wide.x[k], wide_y = laid.wide.y[k];
    const float across = gapCoverage(in_x, wide_x, size_x, wide);
    const float along = gapCoverage(in_y, wide_y, size_y, wide);
    const float open_x = edge_x < 0.5F * (wide + wide_x) ? 1.0F - across : 1.0F;
    const float open_y = edge_y < 0.5F * (wide + wide_y) ? 1.0F - along : 1.0F;
    gap[k] = 1.0F - open_x * open_y;
    places.at.x[k] = in_x;
    places.at.y[k] = in_y;
    places.own.x[k] = edgeCoverage(edge_x, wide_x);
    places.own.y[k] = edgeCoverage(edge_y, wide_y);
    // Far away a pixel covers many cells: their differences cancel.
    places.single[k] = std::min(1.0F, std::min(size_x / wide_x, size_y / wide_y));
    places.column[k] = column;
    places.row[k] = row[k];
  }
}

/// Brightness of a cell, blended into the neighbours' where the footprint reaches over.
float Floor::brightness(const Places& places, int k) const {
  const auto size_x = static_cast<float>(spec_.cell_x), size_y = static_cast<float>(spec_.cell_y);
  const int column = places.column[k], row = places.row[k];
  const float own_x = places.own.x[k], own_y = places.own.y[k];
  const int side_x = 2.0F * places.at.x[k] < size_x ? -1 : 1;
  const int side_y = 2.0F * places.at.y[k] < size_y ? -1 : 1;
  const auto tone = [&](int i, int j) { return signedFloat(cellHash(seed_, i, j)); };
  const auto row_tone = [&](int j) {
    const float here = tone(column, j);
    return own_x < 1.0F ? own_x * here + (1.0F - own_x) * tone(column + side_x, j) : here;
  };
  const float here = row_tone(row);
  const float blend = own_y < 1.0F ? own_y * here + (1.0F - own_y) * row_tone(row + side_y) : here;
  return 1.0F + static_cast<float>(spec_.vary) * places.single[k] * blend;
}

void Floor::cellsAt(const Laid& laid, unsigned members, Cells& cells) const {
  Places places;
  placesOf(laid, places, cells.gap);
  const auto most = static_cast<float>(spec_.tilt);
  int last = -1;  // neighbours mostly share a cell
  forMembers(members, [&](int k) {
    const bool same =
        last >= 0 && places.column[k] == places.column[last] && places.row[k] == places.row[last];
    const auto whole = [&](int j) { return places.own.x[j] >= 1.0F && places.own.y[j] >= 1.0F; };
    const bool alike = same && whole(k) && whole(last);
    cells.brightness[k] = alike ? cells.brightness[last] : brightness(places, k);
    const std::uint64_t own = same ? 0 : cellHash(seed_ ^ 0x7113, places.column[k], places.row[k]);
    cells.shift.x[k] = same ? cells.shift.x[last] : unitFloat(own);
    cells.shift.y[k] = same ? cells.shift.y[last] : unitFloat(mixBits(own));
    cells.tilt.x[k] = same ? cells.tilt.x[last] : most * signedFloat(mixBits(own + 1));
    cells.tilt.y[k] = same ? cells.tilt.y[last] : most * signedFloat(mixBits(own + 2));
    last = k;
  });
  for (int k = 0; k < kPacket; ++k) {
    cells.tilt.x[k] *= places.single[k];
    cells.tilt.y[k] *= places.single[k];
  }
}

void Floor::discShares(const Stripe& stripe, const PointPacket& points, Lanes& shares) {
  const auto r = static_cast<float>(stripe.spec.r);
  for (int k = 0; k < kPacket; ++k) {
    const float x = points.coords.x[k] - stripe.centre.x();
    const float y = points.coords.y[k] - stripe.centre.y();
    const float distance = extentAlong(x, y), inverse = 1.0F / std::max(distance, 1e-6F);
    shares[k] = edgeCoverage(r - distance, extentOf(points.pixel, k, x * inverse, y * inverse));
  }
}

/// Shares of the pixels inside of paint; false if there are none.
SIM_LANES bool Floor::stripeShares(const Stripe& stripe, const PointPacket& points, Lanes& shares) {
  if (stripe.spec.kind == PaintKind::Disc) {
    discShares(stripe, points, shares);
    return anyPositive(shares);
  }
  const float ax = stripe.along.x(), ay = stripe.along.y();
  const float cx = stripe.centre.x(), cy = stripe.centre.y();
  const auto inside = [](float at, float half, float wide) {  // both edges of a thin stripe
    return edgeCoverage(half - at, wide) - edgeCoverage(-half - at, wide);
  };
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    const float x = points.coords.x[k] - cx, y = points.coords.y[k] - cy;
    const float along = std::abs(x * ax + y * ay), across = std::abs(y * ax - x * ay);
    shares[k] = inside(along, stripe.half_along, extentOf(points.pixel, k, ax, ay)) *
                inside(across, stripe.half_across, extentOf(points.pixel, k, -ay, ax));
  }
  return anyPositive(shares);
}

void Floor::paint(const PointPacket& points, const Lanes& grain, const Lanes& wear,
                  Lanes& albedo) const {
  for (const Stripe& stripe : stripes_) {
    Lanes shares;
    if (!stripeShares(stripe, points, shares)) continue;
    const auto rubbed = static_cast<float>(stripe.spec.wear);
    const auto fresh = static_cast<float>(stripe.spec.albedo);
    forMembers(points.members, [&](int k) {
      if (shares[k] <= 0.0F) return;
      const float worn = rubbed * (0.5F + 0.5F * std::tanh(3.0F * grain[k]));
      albedo[k] += shares[k] * (1.0F - worn) * (fresh * wear[k] - albedo[k]);
    });
  }
}

void Floor::grainAt(const Laid& laid, const Cells& cells, Lanes& grain) const {
  if (grain_ == nullptr) return fill(grain, 0.0F);
  const auto size = static_cast<float>(spec_.grain_size);
  Lanes2 at;
  for (int k = 0; k < kPacket; ++k) {
    at.x[k] = laid.at.x[k] + cells.shift.x[k] * size;
    at.y[k] = laid.at.y[k] + cells.shift.y[k] * size;
  }
  grain_->sample(at, laid.pixel, size, grain);
}

SIM_LANES void Floor::at(const PointPacket& points, FloorLook& look) const {
  Laid laid;
  lay(points, laid);
  Cells cells{};
  fill(cells.brightness, 1.0F);
  if (spec_.cell_x > 0.0 && spec_.cell_y > 0.0) cellsAt(laid, points.members, cells);
  Lanes grain, wear, albedo;
  grainAt(laid, cells, grain);
  fill(wear, 0.0F);
  if (blotches_ != nullptr) {
    blotches_->sample(points.coords, points.pixel, static_cast<float>(spec_.blotch_size), wear);
  }
  const auto base = static_cast<float>(spec_.albedo), gap = static_cast<float>(spec_.gap_albedo);
  const auto blotchy = static_cast<float>(spec_.blotch_contrast);
  const auto grainy = static_cast<float>(spec_.grain_contrast);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    wear[k] = 1.0F + blotchy * wear[k];
    const float cell = base * cells.brightness[k] * wear[k] * (1.0F + grainy * grain[k]);
    albedo[k] = cell + cells.gap[k] * (gap * wear[k] - cell);
  }
  paint(points, grain, wear, albedo);
#pragma omp simd
  for (int k = 0; k < kPacket; ++k) {
    look.albedo[k] = std::min(std::max(albedo[k], 0.0F), 1.0F);
    look.gloss[k] = 1.0F - cells.gap[k];
  }
  look.tilt = cells.tilt;
}

}  // namespace ipm_mapping::sim
