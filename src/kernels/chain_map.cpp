#include "ipm_mapping/kernels/chain_map.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

// The same targets as the sampling, which has one of its own for AVX-512 VBMI.
#define HWY_WANT_AVX3_DL

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/chain_map.cpp"
#include "hwy/foreach_target.h"
// foreach_target.h has to come first.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Shorts = hn::Rebind<std::int16_t, Floats>;
using UnsignedShorts = hn::Rebind<std::uint16_t, Floats>;

// Adding this rounds a float of less than 2^22 to the nearest integer, into its low bits.
constexpr float rounder = 12582912.0F;  // 1.5 * 2^23
constexpr float safe_margin = 1.0F;     // pixels
constexpr float safe_turning = 0.95F;   // of the squared radius

constexpr bool vectors = HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR;

// ---- one pixel: the definition, and all there is without vector instructions -------------------

struct RawPixel {
  float u, v, r2;
  bool in_front;
};

HWY_INLINE RawPixel ExactPixel(const RayRow& rays, const Lens& lens, int u) {
  const auto along = [column = static_cast<float>(u)](float start, float step) {
    return start + column * step;
  };
  const float z = along(rays.z, rays.dz);
  const float depth = along(rays.inverse_depth, rays.d_inverse_depth);
  const float scale = 1.0F / z;
  const float x = along(rays.x, rays.dx) * scale, y = along(rays.y, rays.dy) * scale;
  const float xx = x * x, yy = y * y, xy2 = 2.0F * (x * y), r2 = xx + yy;
  const float radial = 1.0F + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const float tangential_x = lens.p1 * xy2 + lens.p2 * (r2 + 2.0F * xx);
  const float tangential_y = lens.p1 * (r2 + 2.0F * yy) + lens.p2 * xy2;
  return {lens.fx * (x * radial + tangential_x) + lens.cx,
          lens.fy * (y * radial + tangential_y) + lens.cy, r2, z > 0.0F && depth > 0.0F};
}

HWY_INLINE bool Inside(const RawPixel& p, const Lens& lens, float margin, float turning) {
  return p.in_front && p.r2 < turning && p.u > margin && p.v > margin &&
         p.u < static_cast<float>(lens.width - 1) - margin &&
         p.v < static_cast<float>(lens.height - 1) - margin;
}

HWY_INLINE int WholeStepsOf(float steps) {
  const float shifted = steps + rounder;
  std::int32_t bits = 0, zero = 0;
  std::memcpy(&bits, &shifted, sizeof bits);
  std::memcpy(&zero, &rounder, sizeof zero);
  return bits - zero;
}

inline void MapPixel(const RayRow& rays, const KeyRows* keys, const Lens& lens,
                     const Samples::Row& samples, int u) {
  constexpr auto steps = static_cast<float>(sample_steps);
  float u_steps = 0.0F, v_steps = 0.0F;
  bool seen = false;
  if (keys != nullptr) {
    const auto i = static_cast<std::size_t>(u);
    const auto mix = [&](auto coordinate) {
      return keys->weights[0] * steps * (*keys->rows[0].*coordinate)[i] +
             keys->weights[1] * steps * (*keys->rows[1].*coordinate)[i] +
             keys->weights[2] * steps * (*keys->rows[2].*coordinate)[i];
    };
    u_steps = mix(&KeyRow::u);
    v_steps = mix(&KeyRow::v);
    seen = u_steps == u_steps;
  }
  if (!seen) {
    const RawPixel p = ExactPixel(rays, lens, u);
    u_steps = p.u * steps;
    v_steps = p.v * steps;
    seen = Inside(p, lens, -0.5F / steps, lens.turning_radius_squared);
  }
  samples.u[u] = samples.v[u] = 0;
  samples.way[u] = sample_outside;
  if (!seen) return;
  const int rounded_u = WholeStepsOf(u_steps), rounded_v = WholeStepsOf(v_steps);
  const int whole_u = std::min(rounded_u >> 7, lens.width - 2);
  const int whole_v = std::min(rounded_v >> 7, lens.height - 2);
  samples.u[u] = static_cast<std::int16_t>(whole_u);
  samples.v[u] = static_cast<std::int16_t>(whole_v);
  samples.way[u] = static_cast<std::uint16_t>((rounded_u - (whole_u << 7)) |
                                              ((rounded_v - (whole_v << 7)) << 8));
}

// ---- vectors ------------------------------------------------------------------------------------

struct RawVector {
  hn::Vec<Floats> u, v, r2;
  hn::Mask<Floats> in_front;
};

HWY_INLINE hn::Vec<Floats> Set(float value) { return hn::Set(Floats(), value); }

HWY_INLINE RawVector Exact(const RayRow& rays, const Lens& lens, int u) {
  const auto column = hn::Iota(Floats(), static_cast<float>(u));
  const auto one = Set(1.0F), two = Set(2.0F);
  const auto z = hn::Add(Set(rays.z), hn::Mul(column, Set(rays.dz)));
  const auto depth = hn::Add(Set(rays.inverse_depth), hn::Mul(column, Set(rays.d_inverse_depth)));
  const auto scale = hn::Div(one, z);
  const auto x = hn::Mul(hn::Add(Set(rays.x), hn::Mul(column, Set(rays.dx))), scale);
  const auto y = hn::Mul(hn::Add(Set(rays.y), hn::Mul(column, Set(rays.dy))), scale);

  const auto xx = hn::Mul(x, x), yy = hn::Mul(y, y), xy2 = hn::Mul(two, hn::Mul(x, y));
  const auto r2 = hn::Add(xx, yy);
  auto radial = hn::Add(Set(lens.k2), hn::Mul(r2, Set(lens.k3)));
  radial = hn::Add(Set(lens.k1), hn::Mul(r2, radial));
  radial = hn::Add(one, hn::Mul(r2, radial));
  const auto tangential_x =
      hn::Add(hn::Mul(Set(lens.p1), xy2), hn::Mul(Set(lens.p2), hn::Add(r2, hn::Mul(two, xx))));
  const auto tangential_y =
      hn::Add(hn::Mul(Set(lens.p1), hn::Add(r2, hn::Mul(two, yy))), hn::Mul(Set(lens.p2), xy2));
  const auto zero = hn::Zero(Floats());
  return {hn::Add(hn::Mul(Set(lens.fx), hn::Add(hn::Mul(x, radial), tangential_x)), Set(lens.cx)),
          hn::Add(hn::Mul(Set(lens.fy), hn::Add(hn::Mul(y, radial), tangential_y)), Set(lens.cy)),
          r2, hn::And(hn::Gt(z, zero), hn::Gt(depth, zero))};
}

HWY_INLINE hn::Mask<Floats> Inside(const RawVector& p, const Lens& lens, float margin,
                                   float turning) {
  const auto right = Set(static_cast<float>(lens.width - 1) - margin);
  const auto bottom = Set(static_cast<float>(lens.height - 1) - margin);
  const auto inside = hn::And(p.in_front, hn::Lt(p.r2, Set(turning)));
  const auto after = hn::And(hn::Gt(p.u, Set(margin)), hn::Gt(p.v, Set(margin)));
  return hn::And(inside, hn::And(after, hn::And(hn::Lt(p.u, right), hn::Lt(p.v, bottom))));
}

HWY_INLINE hn::Vec<Ints> WholeSteps(hn::Vec<Floats> steps) {
  const Ints i;
  return hn::Sub(hn::BitCast(i, hn::Add(steps, Set(rounder))), hn::BitCast(i, Set(rounder)));
}

/// Stores coordinates at least a pixel inside the picture.
HWY_INLINE void StoreInside(hn::Vec<Ints> u, hn::Vec<Ints> v, const Samples::Row& samples, int at) {
  const Ints i;
  const auto mask = hn::Set(i, sample_steps - 1);
  const auto way = hn::Or(hn::And(u, mask), hn::ShiftLeft<8>(hn::And(v, mask)));
  hn::StoreU(hn::DemoteTo(Shorts(), hn::ShiftRight<7>(u)), Shorts(), samples.u + at);
  hn::StoreU(hn::DemoteTo(Shorts(), hn::ShiftRight<7>(v)), Shorts(), samples.v + at);
  hn::StoreU(hn::DemoteTo(UnsignedShorts(), way), UnsignedShorts(), samples.way + at);
}

/// A sample on the last row or column goes the whole way from the one before it.
HWY_INLINE void StoreAnywhere(hn::Vec<Ints> u, hn::Vec<Ints> v, hn::Mask<Ints> seen,
                              const Lens& lens, const Samples::Row& samples, int at) {
  const Ints i;
  const auto whole_u = hn::Min(hn::ShiftRight<7>(u), hn::Set(i, lens.width - 2));
  const auto whole_v = hn::Min(hn::ShiftRight<7>(v), hn::Set(i, lens.height - 2));
  const auto right = hn::Sub(u, hn::ShiftLeft<7>(whole_u));
  const auto down = hn::Sub(v, hn::ShiftLeft<7>(whole_v));
  const auto way =
      hn::IfThenElse(seen, hn::Or(right, hn::ShiftLeft<8>(down)), hn::Set(i, sample_outside));
  hn::StoreU(hn::DemoteTo(Shorts(), hn::IfThenElseZero(seen, whole_u)), Shorts(), samples.u + at);
  hn::StoreU(hn::DemoteTo(Shorts(), hn::IfThenElseZero(seen, whole_v)), Shorts(), samples.v + at);
  hn::StoreU(hn::DemoteTo(UnsignedShorts(), way), UnsignedShorts(), samples.way + at);
}

/// Interpolated coordinates in steps; NaN where a key row has none.
HWY_INLINE hn::Vec<Floats> Mix(const KeyRows& keys, const float* a, const float* b,
                               const float* c) {
  const Floats f;
  const auto first = hn::Mul(Set(keys.weights[0]), hn::LoadU(f, a));
  const auto second = hn::Mul(Set(keys.weights[1]), hn::LoadU(f, b));
  return hn::Add(hn::Add(first, second), hn::Mul(Set(keys.weights[2]), hn::LoadU(f, c)));
}

HWY_ATTR void MapRow(const RayRow& ray_row, const KeyRows* keys, const Lens& lens_model,
                     const Samples::Row& row, int padded_width) {
  if (!vectors) {
    for (int u = 0; u < padded_width; ++u) MapPixel(ray_row, keys, lens_model, row, u);
    return;
  }
  // Copies: the stores below could overwrite the originals, for all that the compiler knows.
  const RayRow rays = ray_row;
  const Lens lens = lens_model;
  const Samples::Row samples = row;
  const auto key = [&](std::size_t k, auto coordinate) {
    return keys == nullptr ? nullptr : (*keys->rows[k].*coordinate).data();
  };
  const std::array<const float*, 3> key_u{key(0, &KeyRow::u), key(1, &KeyRow::u),
                                          key(2, &KeyRow::u)};
  const std::array<const float*, 3> key_v{key(0, &KeyRow::v), key(1, &KeyRow::v),
                                          key(2, &KeyRow::v)};
  KeyRows weights = keys == nullptr ? KeyRows{} : *keys;
  for (float& weight : weights.weights) weight *= sample_steps;
  const auto steps = Set(sample_steps);
  const int lanes = static_cast<int>(hn::Lanes(Floats()));
  for (int u = 0; u < padded_width; u += lanes) {
    auto u_steps = Set(0.0F), v_steps = u_steps;
    auto seen = hn::Lt(u_steps, u_steps);
    if (keys != nullptr) {
      u_steps = Mix(weights, key_u[0] + u, key_u[1] + u, key_u[2] + u);
      v_steps = Mix(weights, key_v[0] + u, key_v[1] + u, key_v[2] + u);
      seen = hn::Eq(u_steps, u_steps);
      if (HWY_LIKELY(hn::AllTrue(Floats(), seen))) {
        StoreInside(WholeSteps(u_steps), WholeSteps(v_steps), samples, u);
        continue;
      }
    }
    const RawVector p = Exact(rays, lens, u);
    u_steps = hn::IfThenElse(seen, u_steps, hn::Mul(p.u, steps));
    v_steps = hn::IfThenElse(seen, v_steps, hn::Mul(p.v, steps));
    seen = hn::Or(seen, Inside(p, lens, -0.5F / sample_steps, lens.turning_radius_squared));
    StoreAnywhere(WholeSteps(u_steps), WholeSteps(v_steps), hn::RebindMask(Ints(), seen), lens,
                  samples, u);
  }
}

HWY_ATTR void MapKeyRow(const RayRow& rays, const Lens& lens, KeyRow& key) {
  const int padded_width = static_cast<int>(key.u.size());
  const float turning = safe_turning * lens.turning_radius_squared;
  if (!vectors) {
    for (std::size_t u = 0; u < key.u.size(); ++u) {
      const RawPixel p = ExactPixel(rays, lens, static_cast<int>(u));
      const bool safe = Inside(p, lens, safe_margin, turning);
      key.u[u] = safe ? p.u : std::numeric_limits<float>::quiet_NaN();
      key.v[u] = safe ? p.v : std::numeric_limits<float>::quiet_NaN();
    }
    return;
  }
  const int lanes = static_cast<int>(hn::Lanes(Floats()));
  const auto none = hn::NaN(Floats());
  for (int u = 0; u < padded_width; u += lanes) {
    const RawVector p = Exact(rays, lens, u);
    const auto safe = Inside(p, lens, safe_margin, turning);
    hn::StoreU(hn::IfThenElse(safe, p.u, none), Floats(), key.u.data() + u);
    hn::StoreU(hn::IfThenElse(safe, p.v, none), Floats(), key.v.data() + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ipm_mapping::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {

HWY_EXPORT(MapRow);
HWY_EXPORT(MapKeyRow);

void mapRow(const RayRow& rays, const KeyRows* keys, const Lens& lens, const Samples::Row& samples,
            int padded_width) {
  HWY_DYNAMIC_DISPATCH(MapRow)(rays, keys, lens, samples, padded_width);
}

void mapKeyRow(const RayRow& rays, const Lens& lens, KeyRow& key) {
  HWY_DYNAMIC_DISPATCH(MapKeyRow)(rays, lens, key);
}

}  // namespace ipm_mapping::kernels
#endif
