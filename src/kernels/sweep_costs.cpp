#include "ipm_mapping/kernels/sweep_costs.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sweep_costs.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

// Plain integer loops are left to the compiler, which vectorises them for the target at hand; only
// the innermost body of the sweep and the gathers are spelled out.
HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::int16_t grey_limit = 8191;

/// (gain * byte + offset) >> 9 in 16 bits: the upper half of a product with byte << 7, and a carry
/// of the lower halves.
struct Brightness {
  using D = hn::ScalableTag<std::int16_t>;
  using Du = hn::RebindToUnsigned<D>;

  Brightness(std::int32_t gain, std::int32_t offset)
      : gain_(hn::Set(Du(), static_cast<std::uint16_t>(gain))),
        rest_(hn::Set(Du(), static_cast<std::uint16_t>((offset & 511) << 7))),
        whole_(hn::Set(D(), static_cast<std::int16_t>(offset >> 9))) {}

  HWY_INLINE hn::Vec<D> of(hn::Vec<Du> byte_128) const {
    const auto low = hn::Mul(byte_128, gain_);
    const auto carries = hn::Ne(hn::SaturatedAdd(low, rest_), hn::Add(low, rest_));
    const auto carry = hn::IfThenElseZero(carries, hn::Set(Du(), 1));
    const auto high = hn::BitCast(D(), hn::Add(hn::MulHigh(byte_128, gain_), carry));
    const auto grey = hn::Add(high, whole_);
    return hn::Min(hn::Max(grey, hn::Set(D(), -grey_limit)), hn::Set(D(), grey_limit));
  }

 private:
  hn::Vec<Du> gain_, rest_;
  hn::Vec<D> whole_;
};

void split(const std::uint8_t* HWY_RESTRICT line, std::int32_t gain, std::int32_t offset, int count,
           std::int16_t* HWY_RESTRICT even, std::int16_t* HWY_RESTRICT odd) {
  const Brightness::D d;
  const Brightness::Du du;
  const Brightness brightness(gain, offset);
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const auto two = hn::LoadU(du, reinterpret_cast<const std::uint16_t*>(line) + i);
    const auto first = hn::ShiftLeft<7>(hn::And(two, hn::Set(du, 255)));
    const auto second = hn::And(hn::ShiftRight<1>(two), hn::Set(du, 255 << 7));
    hn::StoreU(brightness.of(first), d, even + i);
    hn::StoreU(brightness.of(second), d, odd + i);
  }
}

/// Grey levels of a run of rows as floating point, in whole levels.
template <class D>
HWY_INLINE hn::Vec<D> greyLevel(D d, hn::Vec<hn::RebindToSigned<D>> fixed) {
  return hn::Mul(hn::ConvertTo(d, fixed), hn::Set(d, 1.0F / grey_unit));
}

void noise(const NoiseNeighbours& grey, const float* HWY_RESTRICT along,
           const float* HWY_RESTRICT bend_along, const NoiseTerms& terms, int count,
           std::uint16_t* HWY_RESTRICT weight) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  const hn::Rebind<std::uint16_t, decltype(d)> du16;
  const auto load = [&](const std::int16_t* p) { return hn::PromoteTo(di, hn::LoadU(d16, p)); };
  const auto square = [](auto x) { return hn::Mul(x, x); };
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const auto here = load(grey.here + i), left = load(grey.left + i), right = load(grey.right + i);
    const auto far = load(grey.far + i), near = load(grey.near + i);
    const auto twice = hn::Add(here, here);
    const auto dl = greyLevel(d, hn::Sub(right, left)), dr = greyLevel(d, hn::Sub(near, far));
    const auto bend = hn::Add(
        hn::Mul(hn::Set(d, terms.bend_across), greyLevel(d, hn::Sub(hn::Add(right, left), twice))),
        hn::Mul(hn::LoadU(d, bend_along + i), greyLevel(d, hn::Sub(hn::Add(near, far), twice))));
    auto variance =
        hn::Add(hn::Set(d, terms.dark), hn::Mul(hn::Set(d, terms.bright), greyLevel(d, here)));
    variance = hn::Add(variance, hn::Mul(hn::Set(d, terms.across), square(dl)));
    variance = hn::Add(variance, hn::Mul(hn::LoadU(d, along + i), square(dr)));
    variance = hn::Max(hn::Add(variance, square(bend)), hn::Set(d, 0.26F));
    const auto inverse = hn::Div(hn::Set(d, 32768.0F), hn::Sqrt(variance));
    hn::StoreU(hn::DemoteTo(du16, hn::ConvertTo(di, inverse)), du16, weight + i);
  }
}

/// Rows are rounded up to whole vectors, which the spare ones do not change.
constexpr int whole(int count) { return (count + 15) & ~15; }

void evidenceRows(const std::uint16_t* HWY_RESTRICT floor,
                  const std::uint16_t* HWY_RESTRICT vertical,
                  const std::int32_t* HWY_RESTRICT weight, std::int32_t floor_cap,
                  std::int32_t prior, int count, std::int32_t* HWY_RESTRICT evidence) {
  for (int i = 0; i < whole(count); ++i) {
    const std::int32_t f = floor[i];
    const std::int32_t gain =
        std::min(f, floor_cap) - static_cast<std::int32_t>(vertical[i]) - prior;
    evidence[i] += (f == no_cost) | (i >= count) ? 0 : (gain * weight[i]) >> 8;
  }
}

void lower(const std::uint16_t* HWY_RESTRICT other, std::int32_t prior, int count,
           std::uint16_t* HWY_RESTRICT cost) {
  for (int i = 0; i < count; ++i) {
    const std::int32_t there = other[i] + prior, here = cost[i];
    cost[i] = static_cast<std::uint16_t>(here == no_cost ? here : std::min(here, there));
  }
}

/// Rows `upper` and `lower` of the reference blended by the fraction of the shift.
template <class D, class V>
HWY_INLINE V blended(D d, const std::int16_t* upper, const std::int16_t* lower, V fraction) {
  const V a = hn::LoadU(d, upper);
  return hn::Add(a, hn::MulFixedPoint15(hn::Sub(hn::LoadU(d, lower), a), fraction));
}

/// Cost of a vector of rows, the first of them `at`.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToUnsigned<D>> costOf(D d, const VerticalPath& path, std::int64_t at) {
  const hn::RebindToUnsigned<D> du;
  const auto row_fraction = hn::Set(d, path.row_fraction);
  const auto line_fraction = hn::Set(d, path.line_fraction);
  const auto cap = hn::Set(du, static_cast<std::uint16_t>(deviation_cap));
  const auto brighter = hn::Set(d, path.brighter);
  auto sum = hn::Zero(du);
  auto line = blended(d, path.upper + at, path.lower + at, row_fraction);
  for (int k = 0; k < beam_lines; ++k) {
    const auto now = hn::Sub(hn::LoadU(d, path.current + at), brighter);
    const auto weight = hn::LoadU(du, path.weight + at);
    at += path.stride;
    const auto next = blended(d, path.upper + at, path.lower + at, row_fraction);
    const auto seen = hn::Add(line, hn::MulFixedPoint15(hn::Sub(next, line), line_fraction));
    const auto e = hn::BitCast(du, hn::Abs(hn::Sub(now, seen)));
    const auto t = hn::Min(hn::MulHigh(e, weight), cap);
    sum = hn::Add(sum, hn::Mul(t, t));
    line = next;
  }
  return sum;
}

void vertical(const VerticalPath& path, int count, std::uint16_t* HWY_RESTRICT cost) {
  const hn::ScalableTag<std::int16_t> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d)))
    hn::StoreU(costOf(d, path, i), du, cost + i);
}

/// Gains of a block of rows from row `first` on, min(floor, cap) - vertical - prior, or 0 where the
/// floor was not seen and from row `count` of the block on. They fit 16 bits: costs end at
/// beam_lines * deviation_cap^2, caps and priors are no higher.
template <int kRows>
HWY_INLINE void gainsOf(const EvidencePath& path, const EvidenceTerms& terms, int first, int count,
                        std::int16_t* HWY_RESTRICT gains) {
  const hn::CappedTag<std::int16_t, kRows> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto floor_cap = hn::Set(du, static_cast<std::uint16_t>(terms.floor_cap));
  const auto prior = hn::Set(du, static_cast<std::uint16_t>(terms.prior));
  for (int i = 0; i < kRows; i += static_cast<int>(hn::MaxLanes(d))) {
    const auto floor = hn::LoadU(du, path.floor + first + i);
    const auto vertical = hn::Add(costOf(d, path.vertical, first + i), prior);
    const auto gain = hn::Sub(hn::Min(floor, floor_cap), vertical);
    const auto seen = hn::And(hn::Ne(floor, hn::Set(du, no_cost)),
                              hn::FirstN(du, static_cast<std::size_t>(std::max(count - i, 0))));
    hn::StoreU(hn::BitCast(d, hn::IfThenElseZero(seen, gain)), d, gains + i);
  }
}

/// evidence[i] += (gain[i] * weight[i]) >> 8
template <int kRows>
HWY_INLINE void addWeighted(const std::int16_t* HWY_RESTRICT gain,
                            const std::int32_t* HWY_RESTRICT weight,
                            std::int32_t* HWY_RESTRICT evidence) {
  const hn::CappedTag<std::int32_t, kRows> d;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  for (int i = 0; i < kRows; i += static_cast<int>(hn::MaxLanes(d))) {
    const auto g = hn::PromoteTo(d, hn::LoadU(d16, gain + i));
    const auto more = hn::ShiftRight<8>(hn::Mul(g, hn::LoadU(d, weight + i)));
    hn::StoreU(hn::Add(hn::LoadU(d, evidence + i), more), d, evidence + i);
  }
}

/// Evidence of rows begin ... end - 1 from all references, in the first rows of two blocks.
template <int kRows>
HWY_INLINE void blockEvidence(const EvidencePath* paths, int count, const EvidenceTerms& terms,
                              int begin, int end, std::int32_t* HWY_RESTRICT evidence) {
  std::int16_t gains[kRows];
  for (int i = 0; i < 2 * kRows; ++i) evidence[i] = 0;
  for (const EvidencePath* p = paths; p != paths + count; ++p) {
    const int first = std::max(begin, p->begin), rows = std::min(end, p->end) - first;
    if (rows <= 0) continue;
    gainsOf<kRows>(*p, terms, first, rows, gains);
    addWeighted<kRows>(gains, terms.weight + first, evidence + (first - begin));
  }
}

/// Sums of a block's evidence before each of its rows, what they end at and the lowest of them.
template <int kRows>
struct Prefixes {
  std::int32_t before[kRows];
  std::int32_t total = 0, lowest = 0;
};

template <int kRows>
HWY_INLINE void sumUp(const std::int32_t* HWY_RESTRICT evidence, Prefixes<kRows>& out) {
#if HWY_TARGET == HWY_SCALAR
  out.total = out.lowest = 0;
  for (int i = 0; i < kRows; ++i) {
    out.before[i] = out.total;
    out.lowest = std::min(out.lowest, out.total);
    out.total += evidence[i];
  }
#else
  const hn::FixedTag<std::int32_t, 4> d;
  auto sum = hn::Zero(d), lowest = hn::Zero(d);
  for (int i = 0; i < kRows; i += 4) {
    const auto here = hn::LoadU(d, evidence + i);
    auto upTo = hn::Add(here, hn::ShiftLeftLanes<1>(d, here));
    upTo = hn::Add(hn::Add(upTo, hn::ShiftLeftLanes<2>(d, upTo)), sum);
    const auto before = hn::Sub(upTo, here);
    lowest = hn::Min(lowest, before);
    hn::StoreU(before, d, out.before + i);
    sum = hn::Broadcast<3>(upTo);
  }
  out.total = hn::GetLane(sum);
  out.lowest = hn::GetLane(hn::MinOfLanes(d, lowest));
#endif
}

template <int kRows>
HWY_INLINE void climbBy(const EvidencePath* paths, int count, const EvidenceTerms& terms, int begin,
                        int end, int top, std::int32_t least, Climb& climb) {
  std::int32_t evidence[2 * kRows];
  Prefixes<kRows> block;
  for (int last = end; last > begin && !climb.over; last -= kRows) {
    const int first = std::max(begin, last - kRows);
    blockEvidence<kRows>(paths, count, terms, first, last, evidence);
    sumUp<kRows>(evidence, block);
    const std::int32_t most = climb.sum + block.total - block.lowest;
    if (most > climb.best) {
      int row = last - first - 1;
      while (block.before[row] != block.lowest) --row;
      climb.best = most;
      climb.best_row = first + row;
    }
    climb.sum += block.total;
    const std::int32_t reachable = climb.sum + terms.potential[first] - terms.potential[top];
    climb.over = reachable <= climb.best || std::max(climb.best, reachable) < least;
  }
}

/// Blocks as small as a vector fills: most supports are given up in their first block.
void climb(const EvidencePath* paths, int count, const EvidenceTerms& terms, int begin, int end,
           int top, std::int32_t least, Climb& climb) {
  if (end - begin <= 8) return climbBy<8>(paths, count, terms, begin, end, top, least, climb);
  climbBy<HWY_MAX_BYTES == 64 ? 32 : 16>(paths, count, terms, begin, end, top, least, climb);
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(split);
HWY_EXPORT(noise);
HWY_EXPORT(evidenceRows);
HWY_EXPORT(lower);
HWY_EXPORT(vertical);
HWY_EXPORT(climb);

void splitRows(const std::uint8_t* line, std::int32_t gain, std::int32_t offset, int count,
               std::int16_t* even, std::int16_t* odd) {
  HWY_DYNAMIC_DISPATCH(split)(line, gain, offset, count, even, odd);
}

void noiseWeights(const NoiseNeighbours& grey, const float* along, const float* bend_along,
                  const NoiseTerms& terms, int count, std::uint16_t* weight) {
  HWY_DYNAMIC_DISPATCH(noise)(grey, along, bend_along, terms, count, weight);
}

void accumulateEvidence(const std::uint16_t* floor, const std::uint16_t* vertical,
                        const std::int32_t* weight, std::int32_t floor_cap, std::int32_t prior,
                        int count, std::int32_t* evidence) {
  HWY_DYNAMIC_DISPATCH(evidenceRows)
  (floor, vertical, weight, floor_cap, prior, count, evidence);
}

void lowerTo(const std::uint16_t* other, std::int32_t prior, int count, std::uint16_t* cost) {
  HWY_DYNAMIC_DISPATCH(lower)(other, prior, count, cost);
}

void verticalCost(const VerticalPath& path, int count, std::uint16_t* cost) {
  HWY_DYNAMIC_DISPATCH(vertical)(path, count, cost);
}

void climbSupport(const EvidencePath* paths, int count, const EvidenceTerms& terms, int begin,
                  int end, int top, std::int32_t least, Climb& state) {
  HWY_DYNAMIC_DISPATCH(climb)(paths, count, terms, begin, end, top, least, state);
}
}  // namespace ipm_mapping::kernels
#endif
