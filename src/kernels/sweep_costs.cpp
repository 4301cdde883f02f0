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

constexpr std::int32_t grey_limit = 8191;

void split(const std::uint8_t* HWY_RESTRICT line, std::int32_t gain, std::int32_t offset, int count,
           std::int16_t* HWY_RESTRICT even, std::int16_t* HWY_RESTRICT odd) {
  for (int i = 0; i < count; ++i) {
    const std::int32_t e = (gain * line[2 * i] + offset) >> 9;
    const std::int32_t o = (gain * line[2 * i + 1] + offset) >> 9;
    even[i] = static_cast<std::int16_t>(std::min(std::max(e, -grey_limit), grey_limit));
    odd[i] = static_cast<std::int16_t>(std::min(std::max(o, -grey_limit), grey_limit));
  }
}

void blockSums(const std::uint8_t* HWY_RESTRICT in, int blocks, std::int32_t* HWY_RESTRICT sums) {
  for (int b = 0; b < blocks; ++b) {
    std::int32_t sum = 0;
    for (int k = 0; k < 8; ++k) sum += in[8 * b + k];
    sums[b] += sum;
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

template <class D>
HWY_INLINE void verticalRows(D d, const VerticalPath& path, int count,
                             std::uint16_t* HWY_RESTRICT cost) {
  const hn::RebindToUnsigned<D> du;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto row_fraction = hn::Set(d, path.row_fraction);
  const auto line_fraction = hn::Set(d, path.line_fraction);
  const auto cap = hn::Set(du, static_cast<std::uint16_t>(deviation_cap));
  for (int i = 0; i < count; i += lanes) {
    auto sum = hn::Zero(du);
    auto line = blended(d, path.upper + i, path.lower + i, row_fraction);
    for (int k = 0; k < beam_lines; ++k) {
      const std::int64_t at = k * path.stride + i;
      const auto next =
          blended(d, path.upper + at + path.stride, path.lower + at + path.stride, row_fraction);
      const auto seen = hn::Add(line, hn::MulFixedPoint15(hn::Sub(next, line), line_fraction));
      const auto e = hn::BitCast(du, hn::Abs(hn::Sub(hn::LoadU(d, path.current + at), seen)));
      const auto t = hn::Min(hn::MulHigh(e, hn::LoadU(du, path.weight + at)), cap);
      sum = hn::Add(sum, hn::Mul(t, t));
      line = next;
    }
    hn::StoreU(sum, du, cost + i);
  }
}

/// Few rows need no wide vector, and a narrow one costs less.
void vertical(const VerticalPath& path, int count, std::uint16_t* HWY_RESTRICT cost) {
  if (count <= 8) return verticalRows(hn::CappedTag<std::int16_t, 8>(), path, count, cost);
  if (count <= 16) return verticalRows(hn::CappedTag<std::int16_t, 16>(), path, count, cost);
  verticalRows(hn::ScalableTag<std::int16_t>(), path, count, cost);
}

/// Evidence of rows begin ... end - 1 from all references.
HWY_INLINE void blockEvidence(const EvidencePath* paths, int count, const EvidenceTerms& terms,
                              int begin, int end, std::int32_t* HWY_RESTRICT evidence) {
  std::uint16_t cost[evidence_block + overrun];
  for (int i = 0; i < whole(end - begin); ++i) evidence[i] = 0;
  for (const EvidencePath* p = paths; p != paths + count; ++p) {
    const int first = std::max(begin, p->begin), rows = std::min(end, p->end) - first;
    if (rows <= 0) continue;
    VerticalPath path = p->vertical;
    path.current += first;
    path.weight += first;
    path.upper += first;
    path.lower += first;
    vertical(path, rows, cost);
    evidenceRows(p->floor + first, cost, terms.weight + first, terms.floor_cap, terms.prior, rows,
                 evidence + (first - begin));
  }
}

void climb(const EvidencePath* paths, int count, const EvidenceTerms& terms, int begin, int end,
           int top, std::int32_t least, Climb& climb) {
  std::int32_t evidence[evidence_block + overrun];
  for (int last = end; last > begin && !climb.over; last -= evidence_block) {
    const int first = std::max(begin, last - evidence_block);
    blockEvidence(paths, count, terms, first, last, evidence);
    std::int32_t total = 0, gains = 0;
    for (int i = 0; i < whole(last - first); ++i) {
      total += evidence[i];
      gains += std::max(evidence[i], 0);
    }
    std::int32_t sum = climb.sum;
    if (sum + gains > climb.best) {  // otherwise no row of the block is a new top
      for (int i = last - first - 1; i >= 0; --i) {
        sum += evidence[i];
        if (sum > climb.best) climb.best = sum, climb.best_row = first + i;
      }
    }
    climb.sum += total;
    const std::int32_t reachable = climb.sum + terms.potential[first] - terms.potential[top];
    climb.over = reachable <= climb.best || std::max(climb.best, reachable) < least;
  }
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(split);
HWY_EXPORT(blockSums);
HWY_EXPORT(noise);
HWY_EXPORT(evidenceRows);
HWY_EXPORT(lower);
HWY_EXPORT(vertical);
HWY_EXPORT(climb);

void splitRows(const std::uint8_t* line, std::int32_t gain, std::int32_t offset, int count,
               std::int16_t* even, std::int16_t* odd) {
  HWY_DYNAMIC_DISPATCH(split)(line, gain, offset, count, even, odd);
}

void addBlockSums(const std::uint8_t* in, int blocks, std::int32_t* sums) {
  HWY_DYNAMIC_DISPATCH(blockSums)(in, blocks, sums);
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
