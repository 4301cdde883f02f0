#include "ipm_mapping_sim/floor.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping_sim/random.hpp"

namespace ipm_mapping::sim {
namespace {

using Eigen::Vector2f;

float sampleAt(const Texture& texture, const Vector2f& p, const Footprint2& pixel, double size) {
  const float scale = 1.0F / static_cast<float>(size);
  return texture.sample(p * scale, {pixel.dx * scale, pixel.dy * scale});
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

Floor::Cells Floor::cellsAt(const Vector2f& laid, const Footprint2& pixel) const {
  Cells out;
  const auto size_x = static_cast<float>(spec_.cell_x), size_y = static_cast<float>(spec_.cell_y);
  const auto gap = static_cast<float>(spec_.gap), vary = static_cast<float>(spec_.vary);
  const float wide_x = pixel.extent(Vector2f::UnitX()), wide_y = pixel.extent(Vector2f::UnitY());
  const int row = floorOf(laid.y() / size_y);
  float x = laid.x();
  if (spec_.stagger > 0.0) {
    const float part = unitFloat(cellHash(seed_, row, 0x5747));
    x += static_cast<float>(spec_.stagger) * size_x * part;
  }
  const int column = floorOf(x / size_x);
  const float in_x = x - static_cast<float>(column) * size_x;
  const float in_y = laid.y() - static_cast<float>(row) * size_y;
  const float edge_x = std::min(in_x, size_x - in_x), edge_y = std::min(in_y, size_y - in_y);
  const float across =
      edge_x < 0.5F * (gap + wide_x) ? gapCoverage(in_x, wide_x, size_x, gap) : 0.0F;
  const float along =
      edge_y < 0.5F * (gap + wide_y) ? gapCoverage(in_y, wide_y, size_y, gap) : 0.0F;
  out.gap = 1.0F - (1.0F - across) * (1.0F - along);
  // Brightness of the cell, blended into the neighbours' where the footprint reaches over.
  const auto tone = [&](int i, int j) { return signedFloat(cellHash(seed_, i, j)); };
  const int side_x = 2.0F * in_x < size_x ? -1 : 1, side_y = 2.0F * in_y < size_y ? -1 : 1;
  const float own_x = edgeCoverage(edge_x, wide_x), own_y = edgeCoverage(edge_y, wide_y);
  const auto row_tone = [&](int j) {
    const float here = tone(column, j);
    return own_x < 1.0F ? own_x * here + (1.0F - own_x) * tone(column + side_x, j) : here;
  };
  const float here = row_tone(row);
  const float blend = own_y < 1.0F ? own_y * here + (1.0F - own_y) * row_tone(row + side_y) : here;
  out.brightness = 1.0F + vary * blend;
  const std::uint64_t own = cellHash(seed_ ^ 0x7113, column, row);
  out.shift = {unitFloat(own), unitFloat(mixBits(own))};
  if (spec_.tilt == 0.0) return out;
  out.tilt = static_cast<float>(spec_.tilt) *
             Vector2f(signedFloat(mixBits(own + 1)), signedFloat(mixBits(own + 2)));
  return out;
}

float Floor::paintShare(const Stripe& stripe, const Vector2f& p, const Footprint2& pixel) const {
  const Vector2f offset = p - stripe.centre;
  if (stripe.spec.kind == PaintKind::Disc) {
    const float distance = offset.norm(), r = static_cast<float>(stripe.spec.r);
    const Vector2f outward = distance > 1e-6F ? Vector2f(offset / distance) : Vector2f::UnitX();
    return edgeCoverage(r - distance, pixel.extent(outward));
  }
  const float along = std::abs(offset.dot(stripe.along));
  const float across = std::abs(offset.dot(stripe.across));
  const float wide_along = pixel.extent(stripe.along), wide_across = pixel.extent(stripe.across);
  if (along > stripe.half_along + wide_along || across > stripe.half_across + wide_across) {
    return 0.0F;
  }
  const auto inside = [](float at, float half, float wide) {  // both edges of a thin stripe
    return edgeCoverage(half - at, wide) - edgeCoverage(-half - at, wide);
  };
  return inside(along, stripe.half_along, wide_along) *
         inside(across, stripe.half_across, wide_across);
}

FloorLook Floor::at(const Vector2f& p, const Footprint2& pixel) const {
  const Vector2f laid = laid_from_world_ * p;
  const Footprint2 turned{laid_from_world_ * pixel.dx, laid_from_world_ * pixel.dy};
  Cells cells;
  if (spec_.cell_x > 0.0 && spec_.cell_y > 0.0) cells = cellsAt(laid, turned);
  float albedo = static_cast<float>(spec_.albedo) * cells.brightness;
  const Vector2f grain_at = laid + cells.shift * static_cast<float>(spec_.grain_size);
  const float grain = grain_ != nullptr ? sampleAt(*grain_, grain_at, turned, spec_.grain_size) : 0;
  const float blotch =
      blotches_ != nullptr ? sampleAt(*blotches_, p, pixel, spec_.blotch_size) : 0.0F;
  const float wear = 1.0F + static_cast<float>(spec_.blotch_contrast) * blotch;
  albedo *= wear * (1.0F + static_cast<float>(spec_.grain_contrast) * grain);
  albedo += cells.gap * (static_cast<float>(spec_.gap_albedo) * wear - albedo);
  for (const Stripe& stripe : stripes_) {
    const float share = paintShare(stripe, p, pixel);
    if (share <= 0.0F) continue;
    const auto worn =
        static_cast<float>(stripe.spec.wear) * (0.5F + 0.5F * std::tanh(3.0F * grain));
    albedo += share * (1.0F - worn) * (static_cast<float>(stripe.spec.albedo) * wear - albedo);
  }
  return {std::clamp(albedo, 0.0F, 1.0F), 1.0F - cells.gap, cells.tilt};
}

}  // namespace ipm_mapping::sim
