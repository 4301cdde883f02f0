#include "ipm_mapping/kernels/floor_residual.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/sweep_costs.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/floor_residual.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

// Plain integer loops are left to the compiler, which vectorises them for the target at hand; only
// the gathers and the window are spelled out.
HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void blend(const std::int32_t* HWY_RESTRICT a, const std::int32_t* HWY_RESTRICT b, std::int32_t t,
           int count, std::int32_t* HWY_RESTRICT out) {
  for (int i = 0; i < count; ++i) out[i] = ((8 - t) * a[i] + t * b[i]) / 8;
}

void interpolate(const std::int32_t* HWY_RESTRICT nodes, int blocks,
                 std::int32_t* HWY_RESTRICT out) {
  for (int b = 0; b < blocks; ++b) {
    const std::int32_t start = 8 * nodes[b], step = nodes[b + 1] - nodes[b];
    for (int k = 0; k < 8; ++k) out[8 * b + k] = (start + k * step) >> 7;
  }
}

std::int16_t residualOne(const std::uint16_t* pairs, std::int32_t stride, std::int32_t row,
                         std::int32_t line, std::int32_t gain, std::int32_t offset,
                         std::int16_t current) {
  const std::int32_t a = row & 63, b = line & 63;
  const std::uint16_t* p = pairs + (line >> 6) * stride + (row >> 6);
  const std::int32_t here = (64 - b) * (p[0] & 255) + b * (p[0] >> 8);
  const std::int32_t next = (64 - b) * (p[1] & 255) + b * (p[1] >> 8);
  const std::int32_t sample = ((64 - a) * here + a * next) >> 7;
  return static_cast<std::int16_t>(current - ((gain * sample + 32 * offset) >> 14));
}

void path(const std::uint16_t* pairs, std::int32_t stride, const std::int32_t* HWY_RESTRICT row,
          const std::int32_t* HWY_RESTRICT line, std::int32_t gain, std::int32_t offset,
          const std::int16_t* HWY_RESTRICT current, int count,
          std::int16_t* HWY_RESTRICT residual) {
  int i = 0;
#if HWY_TARGET != HWY_SCALAR  // which has no vectors of halves
  const hn::ScalableTag<std::int32_t> d;
  const hn::Repartition<std::uint16_t, decltype(d)> d_half;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto* base = reinterpret_cast<const std::int32_t*>(pairs);
  const auto fraction = hn::Set(d, 63), low_half = hn::Set(d, 0xFFFF), odd = hn::Set(d, 1);
  const auto low_byte = hn::Set(d_half, 255);
  const auto line_bytes = hn::Set(d, 2 * stride), vgain = hn::Set(d, gain);
  const auto voffset = hn::Set(d, 32 * offset);
  for (; i + lanes <= count; i += lanes) {
    const auto r = hn::LoadU(d, row + i), l = hn::LoadU(d, line + i);
    const auto at =
        hn::Add(hn::Mul(hn::ShiftRight<6>(l), line_bytes), hn::AndNot(odd, hn::ShiftRight<5>(r)));
    const auto four = hn::BitCast(d_half, hn::GatherOffset(d, base, at));
    const auto a = hn::And(r, fraction), b = hn::And(l, fraction);
    // one half for the row, one for the next: first between the lines, then between the rows
    const auto b_halves = hn::BitCast(d_half, hn::Or(b, hn::ShiftLeft<16>(b)));
    const auto here = hn::And(four, low_byte), beside = hn::ShiftRight<8>(four);
    const auto halves =
        hn::BitCast(d, hn::Add(hn::ShiftLeft<6>(here), hn::Mul(b_halves, hn::Sub(beside, here))));
    const auto low = hn::And(halves, low_half), step = hn::Sub(hn::ShiftRight<16>(halves), low);
    const auto sample = hn::ShiftRight<7>(hn::Add(hn::ShiftLeft<6>(low), hn::Mul(a, step)));
    const auto warped = hn::ShiftRight<14>(hn::Add(hn::Mul(vgain, sample), voffset));
    const auto now = hn::PromoteTo(d, hn::LoadU(d16, current + i));
    hn::StoreU(hn::DemoteTo(d16, hn::Sub(now, warped)), d16, residual + i);
  }
#endif
  for (; i < count; ++i)
    residual[i] = residualOne(pairs, stride, row[i], line[i], gain, offset, current[i]);
}

void accumulate(const std::int16_t* HWY_RESTRICT residual, std::int32_t sign, int count,
                std::int32_t* HWY_RESTRICT sum, std::int32_t* HWY_RESTRICT number) {
  for (int i = 0; i < count; ++i) {
    sum[i] += sign * residual[i];
    number[i] += sign;
  }
}

void windowed(const std::int32_t* sums, const std::int32_t* numbers, int width, int count,
              std::int16_t* HWY_RESTRICT mean) {
  const hn::ScalableTag<std::int32_t> d;
  const hn::RebindToFloat<decltype(d)> d_float;
  const hn::Rebind<std::int16_t, decltype(d)> d16;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const auto total = hn::Sub(hn::LoadU(d, sums + i + width), hn::LoadU(d, sums + i));
    const auto there = hn::Sub(hn::LoadU(d, numbers + i + width), hn::LoadU(d, numbers + i));
    const auto divisor = hn::ConvertTo(d_float, hn::Max(there, hn::Set(d, 1)));
    const auto quotient = hn::Div(hn::ConvertTo(d_float, total), divisor);
    hn::StoreU(hn::DemoteTo(d16, hn::ConvertTo(d, quotient)), d16, mean + i);
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
    squares[i] = static_cast<std::uint16_t>(t * t);
  }
}

void add(const std::uint16_t* HWY_RESTRICT squares, int count, std::uint16_t* HWY_RESTRICT cost) {
  for (int i = 0; i < count; ++i) cost[i] = static_cast<std::uint16_t>(cost[i] + squares[i]);
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(blend);
HWY_EXPORT(interpolate);
HWY_EXPORT(path);
HWY_EXPORT(accumulate);
HWY_EXPORT(windowed);
HWY_EXPORT(floorSquares);
HWY_EXPORT(add);

void blendNodes(const std::int32_t* a, const std::int32_t* b, std::int32_t t, int count,
                std::int32_t* out) {
  HWY_DYNAMIC_DISPATCH(blend)(a, b, t, count, out);
}

void interpolateNodes(const std::int32_t* nodes, int blocks, std::int32_t* out) {
  HWY_DYNAMIC_DISPATCH(interpolate)(nodes, blocks, out);
}

void pathResidual(ImageView<const std::uint16_t> pairs, const std::int32_t* row,
                  const std::int32_t* line, std::int32_t gain, std::int32_t offset,
                  const std::int16_t* current, int count, std::int16_t* residual) {
  HWY_DYNAMIC_DISPATCH(path)
  (pairs.data, static_cast<std::int32_t>(pairs.stride), row, line, gain, offset, current, count,
   residual);
}

void accumulateResidual(const std::int16_t* residual, int sign, int count, std::int32_t* sum,
                        std::int32_t* number) {
  HWY_DYNAMIC_DISPATCH(accumulate)(residual, sign, count, sum, number);
}

void windowMean(const std::int32_t* sums, const std::int32_t* numbers, int width, int count,
                std::int16_t* mean) {
  HWY_DYNAMIC_DISPATCH(windowed)(sums, numbers, width, count, mean);
}

void squaredFloorDeviation(const std::int16_t* residual, const std::int16_t* mean,
                           const std::uint16_t* weight, int count, std::uint16_t* squares) {
  HWY_DYNAMIC_DISPATCH(floorSquares)(residual, mean, weight, count, squares);
}

void addSquares(const std::uint16_t* squares, int count, std::uint16_t* cost) {
  HWY_DYNAMIC_DISPATCH(add)(squares, count, cost);
}
}  // namespace ipm_mapping::kernels
#endif
