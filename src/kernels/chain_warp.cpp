#include "ipm_mapping/kernels/chain_warp.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

// Byte permutes over two registers (AVX-512 VBMI) are worth a target of their own.
#define HWY_WANT_AVX3_DL

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/chain_warp.cpp"
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

/// The pairs (pixel, its right neighbour in the upper byte) above and below a block of samples, one
/// by one.
HWY_INLINE void GatherBlock(GrayView raw, const std::int16_t* u, const std::int16_t* v,
                            std::uint16_t* above, std::uint16_t* below) {
  const Ints d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto stride = hn::Set(d, static_cast<std::int32_t>(raw.stride));
  HWY_ALIGN std::int32_t offset[Samples::block];
  for (int i = 0; i < Samples::block; i += lanes) {
    const auto column = hn::PromoteTo(d, hn::LoadU(Shorts(), u + i));
    const auto row = hn::PromoteTo(d, hn::LoadU(Shorts(), v + i));
    hn::Store(hn::Add(hn::Mul(row, stride), column), d, offset + i);
  }
  const std::uint8_t *upper = raw.data, *lower = raw.data + raw.stride;
#pragma GCC unroll 16
  for (int i = 0; i < Samples::block; ++i) {
    const std::ptrdiff_t at = offset[i];
    std::memcpy(above + i, upper + at, 2);
    std::memcpy(below + i, lower + at, 2);
  }
}

#if HWY_TARGET == HWY_AVX3_DL
/// Up to 128 bytes from p on, of which `available` may be read; the rest is 0.
struct Window {
  __m512i low, high;
  HWY_ATTR Window(const std::uint8_t* p, int available) {
    const auto first = [](int n) { return n >= 64 ? ~0ULL : (1ULL << n) - 1; };
    low = _mm512_maskz_loadu_epi8(first(available), p);
    high = available <= 64 ? _mm512_setzero_si512()
                           : _mm512_maskz_loadu_epi8(first(available - 64), p + 64);
  }
  [[nodiscard]] HWY_ATTR __m512i at(__m512i index) const {
    return _mm512_permutex2var_epi8(low, index, high);
  }
};

HWY_INLINE void StorePairs(__m512i left, __m512i right, std::uint16_t* pairs) {
  const auto widen = [](__m512i bytes, bool upper) HWY_ATTR {
    return _mm512_cvtepu8_epi16(upper ? _mm512_extracti64x4_epi64(bytes, 1)
                                      : _mm512_castsi512_si256(bytes));
  };
  for (const bool upper : {false, true}) {
    const __m512i pair =
        _mm512_or_si512(widen(left, upper), _mm512_slli_epi16(widen(right, upper), 8));
    _mm512_storeu_si512(pairs + (upper ? 32 : 0), pair);
  }
}

/// One coordinate of a block as bytes above its smallest value; `range` is the largest of them.
struct BlockBytes {
  __m512i bytes;
  int base, range;
};

HWY_INLINE BlockBytes BytesFrom(__m512i a, __m512i b, int base, int range) {
  const __m512i least = _mm512_set1_epi16(static_cast<short>(base));
  const __m256i low = _mm512_cvtepi16_epi8(_mm512_sub_epi16(a, least));
  const __m256i high = _mm512_cvtepi16_epi8(_mm512_sub_epi16(b, least));
  return {_mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1), base, range};
}

/// Smallest and largest among the samples that are seen.
HWY_ATTR HWY_NOINLINE BlockBytes SearchedBytes(const std::int16_t* p, __mmask32 low,
                                               __mmask32 high) {
  const hn::CappedTag<std::int16_t, 32> d;
  const __m512i a = _mm512_loadu_si512(p), b = _mm512_loadu_si512(p + 32);
  const __m512i top = _mm512_set1_epi16(32767), bottom = _mm512_set1_epi16(-1);
  const __m512i least =
      _mm512_min_epi16(_mm512_mask_mov_epi16(top, low, a), _mm512_mask_mov_epi16(top, high, b));
  const __m512i most = _mm512_max_epi16(_mm512_mask_mov_epi16(bottom, low, a),
                                        _mm512_mask_mov_epi16(bottom, high, b));
  const int smallest = hn::GetLane(hn::MinOfLanes(d, hn::Vec<decltype(d)>{least}));
  const int largest = hn::GetLane(hn::MaxOfLanes(d, hn::Vec<decltype(d)>{most}));
  return BytesFrom(a, b, smallest, largest - smallest);
}

/// As SearchedBytes() of a block that is seen whole. Nearly always the extremes of a map along a
/// row stand at its ends or in its middle: look there, and search only where that is wrong.
HWY_INLINE BlockBytes GuessedBytes(const std::int16_t* p) {
  const int smallest = std::min(std::min(p[0], p[32]), p[63]);
  const int largest = std::max(std::max(p[0], p[32]), p[63]);
  const __m512i a = _mm512_loadu_si512(p), b = _mm512_loadu_si512(p + 32);
  const __m512i least = _mm512_set1_epi16(static_cast<short>(smallest));
  const __m512i range = _mm512_set1_epi16(static_cast<short>(largest - smallest));
  const __mmask32 wrong = _mm512_cmpgt_epu16_mask(_mm512_sub_epi16(a, least), range) |
                          _mm512_cmpgt_epu16_mask(_mm512_sub_epi16(b, least), range);
  if (HWY_UNLIKELY(wrong != 0)) return SearchedBytes(p, ~__mmask32{0}, ~__mmask32{0});
  return BytesFrom(a, b, smallest, largest - smallest);
}

/// As GatherBlock(), by permuting whole stretches of the few rows that a block touches; false where
/// it touches more than that.
HWY_INLINE bool PermuteBlock(GrayView raw, const std::int16_t* u, const std::int16_t* v,
                             const std::uint16_t* way, std::uint16_t* above, std::uint16_t* below) {
  constexpr int most_rows = 12, most_columns = 126;
  const __m512i outside = _mm512_set1_epi16(-1);
  const __mmask32 low = _mm512_cmpneq_epi16_mask(_mm512_loadu_si512(way), outside);
  const __mmask32 high = _mm512_cmpneq_epi16_mask(_mm512_loadu_si512(way + 32), outside);
  if ((low | high) == 0) return true;  // nothing will be used
  const bool whole = (low & high) == ~__mmask32{0};
  const BlockBytes columns = whole ? GuessedBytes(u) : SearchedBytes(u, low, high);
  const BlockBytes rows = whole ? GuessedBytes(v) : SearchedBytes(v, low, high);
  if (columns.range > most_columns || rows.range > most_rows) return false;

  const __m512i next = _mm512_add_epi8(columns.bytes, _mm512_set1_epi8(1));
  __m512i left[2] = {}, right[2] = {};  // above, below
  const std::uint8_t* p = raw.data + rows.base * raw.stride + columns.base;
  for (int r = 0; r <= rows.range + 1; ++r, p += raw.stride) {
    const Window window(p, raw.width - columns.base);
    const __m512i a = window.at(columns.bytes), b = window.at(next);
    const __mmask64 top =
        _mm512_cmpeq_epi8_mask(rows.bytes, _mm512_set1_epi8(static_cast<char>(r)));
    const __mmask64 bottom =
        _mm512_cmpeq_epi8_mask(rows.bytes, _mm512_set1_epi8(static_cast<char>(r - 1)));
    left[0] = _mm512_mask_mov_epi8(left[0], top, a);
    right[0] = _mm512_mask_mov_epi8(right[0], top, b);
    left[1] = _mm512_mask_mov_epi8(left[1], bottom, a);
    right[1] = _mm512_mask_mov_epi8(right[1], bottom, b);
  }
  StorePairs(left[0], right[0], above);
  StorePairs(left[1], right[1], below);
  return true;
}
#else
HWY_INLINE bool PermuteBlock(GrayView, const std::int16_t*, const std::int16_t*,
                             const std::uint16_t*, std::uint16_t*, std::uint16_t*) {
  return false;
}
#endif

HWY_INLINE void GatherPairs(GrayView raw, const Samples::Row& samples, int width,
                            std::uint16_t* above, std::uint16_t* below) {
  for (int i = 0; i < width; i += Samples::block) {
    if (!PermuteBlock(raw, samples.u + i, samples.v + i, samples.way + i, above + i, below + i))
      GatherBlock(raw, samples.u + i, samples.v + i, above + i, below + i);
  }
}

using Halves = hn::ScalableTag<std::int16_t>;
using HalfBytes = hn::Rebind<std::uint8_t, Halves>;

/// Mean of a pair in 1/128 grey levels: 0 ... 32640.
HWY_INLINE hn::Vec<Halves> Across(const std::uint16_t* pairs, hn::Vec<Halves> way) {
  const Halves d;
  const hn::RebindToUnsigned<Halves> du;
  const auto pair = hn::LoadU(du, pairs);
  const auto left = hn::BitCast(d, hn::And(pair, hn::Set(du, std::uint16_t{0xFF})));
  const auto right = hn::BitCast(d, hn::ShiftRight<8>(pair));
  return hn::Add(hn::ShiftLeft<7>(left), hn::Mul(hn::Sub(right, left), way));
}

/// Without vector instructions.
inline void SamplePixels(GrayView raw, const Samples::Row& samples, int width, Validity validity,
                         std::uint8_t* out, std::uint8_t* valid) {
  for (int u = 0; u < width; ++u) {
    if (samples.way[u] == sample_outside) {
      out[u] = valid[u] = 0;
      continue;
    }
    const std::uint8_t* p = raw.row(samples.v[u]) + samples.u[u];
    const int right = samples.way[u] & 0xFF, down = samples.way[u] >> 8;
    const int top = p[0] * sample_steps + (p[1] - p[0]) * right;
    p += raw.stride;
    const int bottom = p[0] * sample_steps + (p[1] - p[0]) * right;
    const int fraction = (down << 8) - (down >> 7);
    const int mean = (top >> 1) + (((bottom - top) * fraction) >> 16);
    out[u] = static_cast<std::uint8_t>((mean + 32) >> 6);
    if (validity == Validity::Set) valid[u] = 255;
  }
}

HWY_ATTR void SampleRow(GrayView raw, const Samples::Row& samples, int width, Validity validity,
                        std::uint16_t* scratch, std::uint8_t* out, std::uint8_t* valid) {
  if (!vectors) return SamplePixels(raw, samples, width, validity, out, valid);
  const Halves d;
  const hn::RebindToUnsigned<Halves> words;
  const HalfBytes bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int padded = (width + Samples::block - 1) / Samples::block * Samples::block;
  std::uint16_t* below = scratch + padded;
  GatherPairs(raw, samples, padded, scratch, below);
  for (int u = 0; u < width; u += lanes) {
    const auto way = hn::LoadU(words, samples.way + u);
    const auto right = hn::BitCast(d, hn::And(way, hn::Set(words, std::uint16_t{0xFF})));
    const auto down = hn::BitCast(d, hn::ShiftRight<8>(way));
    const auto top = Across(scratch + u, right);
    const auto bottom = Across(below + u, right);
    // way / 128 as a fraction of 2^15; 128 would overflow: 2^15 - 1 rounds to the same.
    const auto fraction = hn::Sub(hn::ShiftLeft<8>(down), hn::ShiftRight<7>(down));
    const auto mean = hn::Add(hn::ShiftRight<1>(top), hn::MulHigh(hn::Sub(bottom, top), fraction));
    const auto grey = hn::DemoteTo(bytes, hn::ShiftRight<6>(hn::Add(mean, hn::Set(d, 32))));
    const auto none = hn::VecFromMask(words, hn::Eq(way, hn::Set(words, sample_outside)));
    const auto outside = hn::DemoteTo(bytes, hn::BitCast(d, hn::ShiftRight<8>(none)));
    const auto result = hn::AndNot(outside, grey);
    const auto all = hn::Set(bytes, 255);
    if (u + lanes <= width) {
      const auto before = validity == Validity::Set ? all : hn::LoadU(bytes, valid + u);
      hn::StoreU(result, bytes, out + u);
      hn::StoreU(hn::AndNot(outside, before), bytes, valid + u);
      continue;
    }
    // The caller's rows end with the picture.
    HWY_ALIGN std::uint8_t tail[2][HWY_MAX_BYTES];
    const auto rest = static_cast<std::size_t>(width - u);
    std::memcpy(tail[1], valid + u, rest);
    const auto before = validity == Validity::Set ? all : hn::Load(bytes, tail[1]);
    hn::Store(result, bytes, tail[0]);
    hn::Store(hn::AndNot(outside, before), bytes, tail[1]);
    std::memcpy(out + u, tail[0], rest);
    std::memcpy(valid + u, tail[1], rest);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ipm_mapping::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {

HWY_EXPORT(MapRow);
HWY_EXPORT(MapKeyRow);
HWY_EXPORT(SampleRow);

void mapRow(const RayRow& rays, const KeyRows* keys, const Lens& lens, const Samples::Row& samples,
            int padded_width) {
  HWY_DYNAMIC_DISPATCH(MapRow)(rays, keys, lens, samples, padded_width);
}

void mapKeyRow(const RayRow& rays, const Lens& lens, KeyRow& key) {
  HWY_DYNAMIC_DISPATCH(MapKeyRow)(rays, lens, key);
}

void sampleRow(GrayView raw, const Samples::Row& samples, int width, Validity validity,
               std::uint16_t* scratch, std::uint8_t* out, std::uint8_t* valid) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(raw, samples, width, validity, scratch, out, valid);
}

void Samples::resize(int width, int rows) {
  padded_ = (width + block - 1) / block * block;
  const auto n = static_cast<std::size_t>(padded_) * static_cast<std::size_t>(rows);
  u_.assign(n, 0);
  v_.assign(n, 0);
  way_.assign(n, sample_outside);
}

bool Samples::put(const Row& row, int u, double u_raw, double v_raw, int W, int H) {
  const double margin = 0.5 / sample_steps;
  if (!(u_raw > -margin && v_raw > -margin && u_raw < W - 1 + margin && v_raw < H - 1 + margin))
    return false;
  const auto split = [](double coordinate, int size, std::int16_t& pixel) {
    const int rounded = static_cast<int>(coordinate * sample_steps + 0.5);
    const int whole = std::min(rounded / sample_steps, size - 2);
    pixel = static_cast<std::int16_t>(whole);
    return rounded - whole * sample_steps;
  };
  const int right = split(u_raw, W, row.u[u]), down = split(v_raw, H, row.v[u]);
  row.way[u] = static_cast<std::uint16_t>(right | (down << 8));
  return true;
}

}  // namespace ipm_mapping::kernels
#endif
