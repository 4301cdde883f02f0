#include "ipm_mapping/kernels/floor_residual.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/sweep_costs.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/floor_residual.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

// Plain integer loops are left to the compiler, which vectorises them for the target at hand; only
// the gathers and the running sums are spelled out.
HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(interpolate);
HWY_EXPORT(path);
HWY_EXPORT(accumulate);
HWY_EXPORT(prefixes);
HWY_EXPORT(windowed);
HWY_EXPORT(floorSquares);

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

void accumulateFloorCost(const std::int16_t* residual, const std::int16_t* mean,
                         const std::uint16_t* weight, int count, std::uint16_t* squares) {
  HWY_DYNAMIC_DISPATCH(floorSquares)(residual, mean, weight, count, squares);
}
}  // namespace ipm_mapping::kernels
#endif
