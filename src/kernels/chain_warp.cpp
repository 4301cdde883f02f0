#include "ipm_mapping/kernels/chain_warp.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

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
using Bytes = hn::Rebind<std::uint8_t, Floats>;

/// Splits rounded coordinates into pixel and way; a sample on the last row or column goes the whole
/// way from the one before it.
HWY_ATTR void StoreCoordinate(hn::Vec<Floats> coordinate, hn::Mask<Floats> seen, int size,
                              std::int16_t* pixel, std::uint8_t* way) {
  const Floats f;
  const Ints i;
  const auto rounded = hn::ConvertTo(
      i, hn::IfThenElseZero(
             seen, hn::Add(hn::Mul(coordinate, hn::Set(f, sample_steps)), hn::Set(f, 0.5F))));
  const auto whole = hn::Min(hn::ShiftRight<7>(rounded), hn::Set(i, size - 2));
  const auto rest = hn::Sub(rounded, hn::ShiftLeft<7>(whole));
  hn::StoreU(hn::DemoteTo(Shorts(), whole), Shorts(), pixel);
  const auto marked = hn::IfThenElse(hn::RebindMask(i, seen), rest, hn::Set(i, sample_outside));
  hn::StoreU(hn::DemoteTo(Bytes(), marked), Bytes(), way);
}

HWY_ATTR void MapRow(const RayRow& rays, const Lens& lens, const Samples::Row& samples,
                     int padded_width) {
  const Floats f;
  const auto set = [f](float value) HWY_ATTR { return hn::Set(f, value); };
  const auto one = set(1.0F), two = set(2.0F), half_step = set(0.5F / sample_steps);
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int u = 0; u < padded_width; u += lanes) {
    const auto column = hn::Iota(f, static_cast<float>(u));
    const auto along = [&](float start, float step)
                           HWY_ATTR { return hn::Add(set(start), hn::Mul(column, set(step))); };
    const auto z = along(rays.z, rays.dz);
    const auto depth = along(rays.inverse_depth, rays.d_inverse_depth);
    const auto scale = hn::Div(one, z);
    const auto x = hn::Mul(along(rays.x, rays.dx), scale);
    const auto y = hn::Mul(along(rays.y, rays.dy), scale);

    const auto xx = hn::Mul(x, x), yy = hn::Mul(y, y), xy2 = hn::Mul(two, hn::Mul(x, y));
    const auto r2 = hn::Add(xx, yy);
    auto radial = hn::Add(set(lens.k2), hn::Mul(r2, set(lens.k3)));
    radial = hn::Add(set(lens.k1), hn::Mul(r2, radial));
    radial = hn::Add(one, hn::Mul(r2, radial));
    const auto tangential_x =
        hn::Add(hn::Mul(set(lens.p1), xy2), hn::Mul(set(lens.p2), hn::Add(r2, hn::Mul(two, xx))));
    const auto tangential_y =
        hn::Add(hn::Mul(set(lens.p1), hn::Add(r2, hn::Mul(two, yy))), hn::Mul(set(lens.p2), xy2));
    const auto u_raw =
        hn::Add(hn::Mul(set(lens.fx), hn::Add(hn::Mul(x, radial), tangential_x)), set(lens.cx));
    const auto v_raw =
        hn::Add(hn::Mul(set(lens.fy), hn::Add(hn::Mul(y, radial), tangential_y)), set(lens.cy));

    const auto zero = hn::Zero(f), lowest = hn::Neg(half_step);
    const auto right = hn::Add(set(static_cast<float>(lens.width - 1)), half_step);
    const auto bottom = hn::Add(set(static_cast<float>(lens.height - 1)), half_step);
    auto seen = hn::And(hn::Gt(z, zero), hn::Gt(depth, zero));
    seen = hn::And(seen, hn::Lt(r2, set(lens.turning_radius_squared)));
    seen = hn::And(seen, hn::And(hn::Gt(u_raw, lowest), hn::Gt(v_raw, lowest)));
    seen = hn::And(seen, hn::And(hn::Lt(u_raw, right), hn::Lt(v_raw, bottom)));
    StoreCoordinate(u_raw, seen, lens.width, samples.u + u, samples.right + u);
    StoreCoordinate(v_raw, seen, lens.height, samples.v + u, samples.down + u);
  }
}

/// The pairs (pixel, its right neighbour in the upper byte) above and below a block of samples, one
/// by one.
HWY_ATTR void GatherBlock(GrayView raw, const std::int16_t* u, const std::int16_t* v,
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
  for (int i = 0; i < Samples::block; ++i) {
    std::memcpy(above + i, raw.data + offset[i], 2);
    std::memcpy(below + i, raw.data + offset[i] + raw.stride, 2);
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

HWY_ATTR void StorePairs(__m512i left, __m512i right, std::uint16_t* pairs) {
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

/// As GatherBlock(), by permuting whole stretches of the few rows that a block touches; false where
/// it touches more than that.
HWY_ATTR bool PermuteBlock(GrayView raw, const std::int16_t* u, const std::int16_t* v,
                           const std::uint8_t* way, std::uint16_t* above, std::uint16_t* below) {
  constexpr int most_rows = 12, most_columns = 126;
  const hn::CappedTag<std::int16_t, 32> d;
  const __mmask64 seen = _mm512_cmpneq_epi8_mask(_mm512_loadu_si512(way), _mm512_set1_epi8(-1));
  if (seen == 0) return true;  // nothing will be used
  const auto low = static_cast<__mmask32>(seen), high = static_cast<__mmask32>(seen >> 32);
  const auto range = [&](const std::int16_t* p, int& smallest, int& largest) HWY_ATTR {
    const __m512i a = _mm512_loadu_si512(p), b = _mm512_loadu_si512(p + 32);
    const __m512i top = _mm512_set1_epi16(32767), bottom = _mm512_set1_epi16(-1);
    const __m512i least =
        _mm512_min_epi16(_mm512_mask_mov_epi16(top, low, a), _mm512_mask_mov_epi16(top, high, b));
    const __m512i most = _mm512_max_epi16(_mm512_mask_mov_epi16(bottom, low, a),
                                          _mm512_mask_mov_epi16(bottom, high, b));
    smallest = hn::GetLane(hn::MinOfLanes(d, hn::Vec<decltype(d)>{least}));
    largest = hn::GetLane(hn::MaxOfLanes(d, hn::Vec<decltype(d)>{most}));
    const __m512i base = _mm512_set1_epi16(static_cast<short>(smallest));
    return _mm512_inserti64x4(
        _mm512_castsi256_si512(_mm512_cvtepi16_epi8(_mm512_sub_epi16(a, base))),
        _mm512_cvtepi16_epi8(_mm512_sub_epi16(b, base)), 1);
  };
  int u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  const __m512i column = range(u, u0, u1), row = range(v, v0, v1);
  if (u1 - u0 > most_columns || v1 - v0 > most_rows) return false;

  const __m512i next = _mm512_add_epi8(column, _mm512_set1_epi8(1));
  __m512i left[2] = {}, right[2] = {};  // above, below
  for (int r = 0; r <= v1 - v0 + 1; ++r) {
    const Window window(raw.data + (v0 + r) * raw.stride + u0, raw.width - u0);
    const __m512i a = window.at(column), b = window.at(next);
    const __mmask64 top = _mm512_cmpeq_epi8_mask(row, _mm512_set1_epi8(static_cast<char>(r)));
    const __mmask64 bottom =
        _mm512_cmpeq_epi8_mask(row, _mm512_set1_epi8(static_cast<char>(r - 1)));
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
                             const std::uint8_t*, std::uint16_t*, std::uint16_t*) {
  return false;
}
#endif

HWY_ATTR void GatherPairs(GrayView raw, const Samples::Row& samples, int width,
                          std::uint16_t* above, std::uint16_t* below) {
  for (int i = 0; i < width; i += Samples::block) {
    if (!PermuteBlock(raw, samples.u + i, samples.v + i, samples.right + i, above + i, below + i))
      GatherBlock(raw, samples.u + i, samples.v + i, above + i, below + i);
  }
}

using Halves = hn::ScalableTag<std::int16_t>;
using HalfBytes = hn::Rebind<std::uint8_t, Halves>;

/// Mean of a pair in 1/128 grey levels: 0 ... 32640.
HWY_ATTR hn::Vec<Halves> Across(const std::uint16_t* pairs, hn::Vec<Halves> way) {
  const Halves d;
  const hn::RebindToUnsigned<Halves> du;
  const auto pair = hn::LoadU(du, pairs);
  const auto left = hn::BitCast(d, hn::And(pair, hn::Set(du, std::uint16_t{0xFF})));
  const auto right = hn::BitCast(d, hn::ShiftRight<8>(pair));
  return hn::Add(hn::ShiftLeft<7>(left), hn::Mul(hn::Sub(right, left), way));
}

HWY_ATTR void SampleRow(GrayView raw, const Samples::Row& samples, int width, Validity validity,
                        std::uint16_t* scratch, std::uint8_t* out, std::uint8_t* valid) {
  const Halves d;
  const HalfBytes bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int padded = (width + Samples::block - 1) / Samples::block * Samples::block;
  std::uint16_t* below = scratch + padded;
  GatherPairs(raw, samples, padded, scratch, below);
  for (int u = 0; u < width; u += lanes) {
    const auto right = hn::LoadU(bytes, samples.right + u);
    const auto down = hn::PromoteTo(d, hn::LoadU(bytes, samples.down + u));
    const auto top = Across(scratch + u, hn::PromoteTo(d, right));
    const auto bottom = Across(below + u, hn::PromoteTo(d, right));
    // way / 128 as a fraction of 2^15; 128 would overflow: 2^15 - 1 rounds to the same.
    const auto fraction = hn::Sub(hn::ShiftLeft<8>(down), hn::ShiftRight<7>(down));
    const auto mean = hn::Add(hn::ShiftRight<1>(top), hn::MulHigh(hn::Sub(bottom, top), fraction));
    const auto grey = hn::DemoteTo(bytes, hn::ShiftRight<6>(hn::Add(mean, hn::Set(d, 32))));
    const auto outside = hn::VecFromMask(bytes, hn::Eq(right, hn::Set(bytes, sample_outside)));
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
HWY_EXPORT(SampleRow);

void mapRow(const RayRow& rays, const Lens& lens, const Samples::Row& samples, int padded_width) {
  HWY_DYNAMIC_DISPATCH(MapRow)(rays, lens, samples, padded_width);
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
  right_.assign(n, sample_outside);
  down_.assign(n, sample_outside);
}

bool Samples::put(const Row& row, int u, double u_raw, double v_raw, int W, int H) {
  const double margin = 0.5 / sample_steps;
  if (!(u_raw > -margin && v_raw > -margin && u_raw < W - 1 + margin && v_raw < H - 1 + margin))
    return false;
  const auto split = [](double coordinate, int size, std::int16_t& pixel, std::uint8_t& way) {
    const int rounded = static_cast<int>(coordinate * sample_steps + 0.5);
    const int whole = std::min(rounded / sample_steps, size - 2);
    pixel = static_cast<std::int16_t>(whole);
    way = static_cast<std::uint8_t>(rounded - whole * sample_steps);
  };
  split(u_raw, W, row.u[u], row.right[u]);
  split(v_raw, H, row.v[u], row.down[u]);
  return true;
}

}  // namespace ipm_mapping::kernels
#endif
