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

void interpolate(const std::int32_t* HWY_RESTRICT nodes, int blocks,
                 std::int32_t* HWY_RESTRICT out) {
  for (int b = 0; b < blocks; ++b) {
    const std::int32_t start = 8 * nodes[b], step = nodes[b + 1] - nodes[b];
    for (int k = 0; k < 8; ++k) out[8 * b + k] = (start + k * step) >> 7;
  }
}

std::int16_t residualOne(const std::uint8_t* reference, std::int32_t stride, std::int32_t row,
                         std::int32_t line, std::int32_t gain, std::int32_t offset,
                         std::int16_t current) {
  const std::int32_t a = row & 63, b = line & 63;
  const std::uint8_t* p = reference + (line >> 6) * stride + (row >> 6);
  const std::uint8_t* q = p + stride;
  const std::int32_t here = (64 - a) * p[0] + a * p[1], next = (64 - a) * q[0] + a * q[1];
  const std::int32_t sample = ((64 - b) * here + b * next) >> 7;
  return static_cast<std::int16_t>(current - ((gain * sample + 32 * offset) >> 14));
}

void path(const std::uint8_t* reference, std::int32_t stride, const std::int32_t* HWY_RESTRICT row,
          const std::int32_t* HWY_RESTRICT line, std::int32_t gain, std::int32_t offset,
          const std::int16_t* HWY_RESTRICT current, int count,
          std::int16_t* HWY_RESTRICT residual) {
  const hn::ScalableTag<std::int32_t> d;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto* base = reinterpret_cast<const std::int32_t*>(reference);
  const auto v64 = hn::Set(d, 64), fraction = hn::Set(d, 63), byte = hn::Set(d, 255);
  const auto vstride = hn::Set(d, stride), vgain = hn::Set(d, gain);
  const auto voffset = hn::Set(d, 32 * offset);
  int i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto r = hn::LoadU(d, row + i), l = hn::LoadU(d, line + i);
    const auto at = hn::Add(hn::Mul(hn::ShiftRight<6>(l), vstride), hn::ShiftRight<6>(r));
    const auto p = hn::GatherOffset(d, base, at);
    const auto q = hn::GatherOffset(d, base, hn::Add(at, vstride));
    const auto a = hn::And(r, fraction), b = hn::And(l, fraction);
    const auto rest = hn::Sub(v64, a);
    const auto here =
        hn::Add(hn::Mul(rest, hn::And(p, byte)), hn::Mul(a, hn::And(hn::ShiftRight<8>(p), byte)));
    const auto next =
        hn::Add(hn::Mul(rest, hn::And(q, byte)), hn::Mul(a, hn::And(hn::ShiftRight<8>(q), byte)));
    const auto sample =
        hn::ShiftRight<7>(hn::Add(hn::Mul(hn::Sub(v64, b), here), hn::Mul(b, next)));
    const auto warped = hn::ShiftRight<14>(hn::Add(hn::Mul(vgain, sample), voffset));
    const auto now = hn::PromoteTo(d, hn::LoadU(d16, current + i));
    hn::StoreU(hn::DemoteTo(d16, hn::Sub(now, warped)), d16, residual + i);
  }
  for (; i < count; ++i)
    residual[i] = residualOne(reference, stride, row[i], line[i], gain, offset, current[i]);
}

void accumulate(const std::int16_t* HWY_RESTRICT residual, int sign, int count,
                std::int32_t* HWY_RESTRICT sum, std::int32_t* HWY_RESTRICT number) {
  for (int i = 0; i < count; ++i) {
    const bool there = residual[i] != no_residual;
    sum[i] += there ? sign * residual[i] : 0;
    number[i] += there ? sign : 0;
  }
}

void prefixes(const std::int32_t* HWY_RESTRICT values, int half, int count,
              std::int32_t* HWY_RESTRICT prefix) {
  std::fill_n(prefix, half + 1, 0);
  std::int32_t* HWY_RESTRICT upTo = prefix + half + 1;
  int i = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::FixedTag<std::int32_t, 4> d;
  auto before = hn::Zero(d);
  for (; i + 4 <= count; i += 4) {
    auto sum = hn::LoadU(d, values + i);
    sum = hn::Add(sum, hn::ShiftLeftLanes<1>(d, sum));
    sum = hn::Add(sum, hn::ShiftLeftLanes<2>(d, sum));
    sum = hn::Add(sum, before);
    hn::StoreU(sum, d, upTo + i);
    before = hn::Broadcast<3>(sum);
  }
#endif
  for (; i < count; ++i) upTo[i] = upTo[i - 1] + values[i];
  std::fill_n(upTo + count, half, upTo[count - 1]);
}

void windowed(const std::int32_t* HWY_RESTRICT sum_prefix,
              const std::int32_t* HWY_RESTRICT number_prefix, int half, int count,
              std::int16_t* HWY_RESTRICT mean) {
  const int width = 2 * half + 1;
  for (int i = 0; i < count; ++i) {
    const std::int32_t sum = sum_prefix[i + width] - sum_prefix[i];
    const std::int32_t number = number_prefix[i + width] - number_prefix[i];
    const float quotient = static_cast<float>(sum) / static_cast<float>(std::max(number, 1));
    mean[i] = static_cast<std::int16_t>(static_cast<std::int32_t>(quotient));
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

void floorSquares(const std::int16_t* HWY_RESTRICT residual, const std::int16_t* HWY_RESTRICT mean,
                  const std::uint16_t* HWY_RESTRICT weight, int count,
                  std::uint16_t* HWY_RESTRICT squares) {
  for (int i = 0; i < count; ++i) {
    const std::int16_t e = residual[i], m = mean[i];
    const auto plain = static_cast<std::uint16_t>(e < 0 ? -e : e);
    const auto d = static_cast<std::int16_t>(e - m);
    const auto drift = static_cast<std::uint16_t>(d < 0 ? -d : d);
    const std::uint16_t smaller = plain < drift ? plain : drift;
    const auto scaled =
        static_cast<std::uint16_t>((static_cast<std::uint32_t>(smaller) * weight[i]) >> 16);
    const std::uint16_t t = scaled < deviation_cap ? scaled : deviation_cap;
    const auto sum = static_cast<std::uint16_t>(squares[i] + static_cast<std::uint16_t>(t * t));
    squares[i] = e == no_residual || squares[i] == no_cost ? no_cost : sum;
  }
}

/// Rows `upper` and `lower` of the reference blended by the fraction of the shift.
template <class D, class V>
HWY_INLINE V blended(D d, const std::int16_t* upper, const std::int16_t* lower, V fraction) {
  const V a = hn::LoadU(d, upper);
  const V step = hn::Sub(hn::LoadU(d, lower), a);
  return hn::Add(a, hn::MulHigh(hn::Add(step, step), fraction));
}

void vertical(const VerticalPath& path, int count, std::uint16_t* HWY_RESTRICT cost) {
  const hn::ScalableTag<std::int16_t> d;
  const hn::RebindToUnsigned<decltype(d)> du;
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
      const auto step = hn::Sub(next, line);
      const auto seen = hn::Add(line, hn::MulHigh(hn::Add(step, step), line_fraction));
      const auto e = hn::BitCast(du, hn::Abs(hn::Sub(hn::LoadU(d, path.current + at), seen)));
      const auto t = hn::Min(hn::MulHigh(e, hn::LoadU(du, path.weight + at)), cap);
      sum = hn::Add(sum, hn::Mul(t, t));
      line = next;
    }
    hn::StoreU(sum, du, cost + i);
  }
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
HWY_EXPORT(interpolate);
HWY_EXPORT(path);
HWY_EXPORT(accumulate);
HWY_EXPORT(prefixes);
HWY_EXPORT(windowed);
HWY_EXPORT(floorSquares);
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

void interpolateNodes(const std::int32_t* nodes, int blocks, std::int32_t* out) {
  HWY_DYNAMIC_DISPATCH(interpolate)(nodes, blocks, out);
}

void pathResidual(const std::uint8_t* reference, std::int32_t stride, const std::int32_t* row,
                  const std::int32_t* line, std::int32_t gain, std::int32_t offset,
                  const std::int16_t* current, int count, std::int16_t* residual) {
  HWY_DYNAMIC_DISPATCH(path)
  (reference, stride, row, line, gain, offset, current, count, residual);
}

void accumulateResidual(const std::int16_t* residual, int sign, int count, std::int32_t* sum,
                        std::int32_t* number) {
  HWY_DYNAMIC_DISPATCH(accumulate)(residual, sign, count, sum, number);
}

void prefixSums(const std::int32_t* values, int half, int count, std::int32_t* prefix) {
  HWY_DYNAMIC_DISPATCH(prefixes)(values, half, count, prefix);
}

void windowMean(const std::int32_t* sum_prefix, const std::int32_t* number_prefix, int half,
                int count, std::int16_t* mean) {
  HWY_DYNAMIC_DISPATCH(windowed)(sum_prefix, number_prefix, half, count, mean);
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

void accumulateFloorCost(const std::int16_t* residual, const std::int16_t* mean,
                         const std::uint16_t* weight, int count, std::uint16_t* squares) {
  HWY_DYNAMIC_DISPATCH(floorSquares)(residual, mean, weight, count, squares);
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
