#include "ipm_mapping/kernels/chain_sample.hpp"

#include <algorithm>
#include <cstring>

// Byte permutes over two registers (AVX-512 VBMI) are worth a target of their own.
#define HWY_WANT_AVX3_DL

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/chain_sample.cpp"
#include "hwy/foreach_target.h"
// foreach_target.h has to come first.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::ScalableTag<std::int32_t>;
using Shorts = hn::Rebind<std::int16_t, Ints>;

constexpr bool vectors = HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR;

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

HWY_EXPORT(SampleRow);

void sampleRow(GrayView raw, const Samples::Row& samples, int width, Validity validity,
               std::uint16_t* scratch, std::uint8_t* out, std::uint8_t* valid) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(raw, samples, width, validity, scratch, out, valid);
}

}  // namespace ipm_mapping::kernels
#endif
