#include "ipm_mapping/kernels/sweep_rectify.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sweep_rectify.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "sweep_math_body.hpp"

// The compiler vectorises these loops for the target at hand.
void smoothRow(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
               int width, std::uint8_t* HWY_RESTRICT out) {
  for (int u = 1; u < width - 1; ++u) {
    const int left = above[u - 1] + 2 * here[u - 1] + below[u - 1];
    const int middle = above[u] + 2 * here[u] + below[u];
    const int right = above[u + 1] + 2 * here[u + 1] + below[u + 1];
    out[u] =
        static_cast<std::uint8_t>(static_cast<std::uint16_t>(left + 2 * middle + right + 8) >> 4);
  }
  for (const int u : {0, width - 1}) {
    const int l = std::max(u - 1, 0), r = std::min(u + 1, width - 1);
    const int sum = above[l] + 2 * above[u] + above[r] + 2 * (here[l] + 2 * here[u] + here[r]) +
                    below[l] + 2 * below[u] + below[r];
    out[u] = static_cast<std::uint8_t>((sum + 8) >> 4);
  }
}

void smooth(GrayView in, GrayBuffer out) {
  for (int v = 0; v < in.height; ++v)
    smoothRow(in.row(std::max(v - 1, 0)), in.row(v), in.row(std::min(v + 1, in.height - 1)),
              in.width, out.row(v));
}

void pair(GrayView in, ImageView<std::uint16_t> out) {
  for (int v = 0; v < in.height; ++v) {
    const std::uint8_t* HWY_RESTRICT a = in.row(v);
    const std::uint8_t* HWY_RESTRICT b = in.row(std::min(v + 1, in.height - 1));
    std::uint16_t* HWY_RESTRICT o = out.row(v);
    for (int u = 0; u < in.width; ++u) o[u] = static_cast<std::uint16_t>(a[u] | (b[u] << 8));
  }
}

std::uint8_t sampleOne(const std::uint8_t* bytes, std::uint32_t weights, std::uint32_t gain) {
  std::uint32_t sum = 0;
  for (int k = 0; k < 4; ++k) sum += bytes[k] * ((weights >> (8 * k)) & 255U);
  return static_cast<std::uint8_t>(std::min((sum * gain + (1U << 20)) >> 21, 255U));
}

void sample(const std::uint8_t* bytes, const std::int32_t* HWY_RESTRICT offsets,
            const std::uint32_t* HWY_RESTRICT weights, const std::uint16_t* HWY_RESTRICT gains,
            int count, std::uint8_t* HWY_RESTRICT out) {
  int i = 0;
#if HWY_TARGET != HWY_SCALAR  // which has no vectors of bytes
  const hn::ScalableTag<std::uint32_t> d32;
  const hn::RebindToSigned<decltype(d32)> di32;
  const hn::Repartition<std::uint16_t, decltype(d32)> d16;
  const hn::Rebind<std::uint8_t, decltype(d32)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d32));
  const auto low_bytes = hn::Set(d32, 0x00FF00FFU);
  const auto low_half = hn::Set(d32, 0x0000FFFFU);
  const hn::Rebind<std::uint16_t, decltype(d32)> d_gain;
  const auto rounding = hn::Set(d32, 1U << 20);
  for (; i + lanes <= count; i += lanes) {
    const auto four = hn::GatherOffset(d32, reinterpret_cast<const std::uint32_t*>(bytes),
                                       hn::LoadU(di32, offsets + i));
    const auto w = hn::LoadU(d32, weights + i);
    const auto even = hn::Mul(hn::BitCast(d16, hn::And(four, low_bytes)),
                              hn::BitCast(d16, hn::And(w, low_bytes)));
    const auto odd = hn::Mul(hn::BitCast(d16, hn::And(hn::ShiftRight<8>(four), low_bytes)),
                             hn::BitCast(d16, hn::And(hn::ShiftRight<8>(w), low_bytes)));
    const auto both = hn::BitCast(d32, hn::Add(even, odd));  // at most 255 * 128 a half
    const auto sum = hn::Add(hn::And(both, low_half), hn::ShiftRight<16>(both));
    const auto gain = hn::PromoteTo(d32, hn::LoadU(d_gain, gains + i));
    const auto grey = hn::ShiftRight<21>(hn::Add(hn::Mul(sum, gain), rounding));
    hn::StoreU(hn::DemoteTo(d8, hn::BitCast(di32, grey)), d8, out + i);
  }
#endif
  for (; i < count; ++i) out[i] = sampleOne(bytes + offsets[i], weights[i], gains[i]);
}

/// A coordinate at row i moved by rows and lines, within its bounds.
HWY_INLINE Vf movedTo(Floats d, const float* here, const float* before, const float* after, int i,
                      Vf along, Vf across, float least, float most) {
  const Vf half = hn::Set(d, 0.5F);
  const Vf by_row = hn::Mul(half, hn::Sub(hn::LoadU(d, here + i + 1), hn::LoadU(d, here + i - 1)));
  const Vf by_line = hn::Mul(half, hn::Sub(hn::LoadU(d, after + i), hn::LoadU(d, before + i)));
  const Vf to = hn::Add(hn::LoadU(d, here + i), sumOfProducts(along, by_row, across, by_line));
  return hn::Min(hn::Max(to, hn::Set(d, least)), hn::Set(d, most));
}

void plan(const RawLine& line, const MovedRows& m, const RawBounds& bounds, int begin, int end,
          std::int32_t* HWY_RESTRICT offsets, std::uint32_t* HWY_RESTRICT weights) {
  const Floats d;
  const Ints di;
  const hn::RebindToUnsigned<Floats> du;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto all = hn::Set(di, 128);
  const Vf unit = hn::Set(d, 128.0F), half = hn::Set(d, 0.5F);
  const auto width = hn::Set(di, bounds.width);
  for (int i = begin; i < end; i += lanes) {
    const Vf nearness = hn::LoadU(d, m.nearness + i);
    const Vf time =
        hn::Sub(hn::Mul(hn::LoadU(d, line.v + i), hn::Set(d, bounds.read_per_pixel)), half);
    const Vf rows = hn::Mul(hn::Mul(time, hn::Set(d, m.ahead)), nearness);
    const Vf along = hn::Min(hn::Max(rows, hn::Set(d, -m.most_rows)), hn::Set(d, m.most_rows));
    const Vf lines =
        hn::Mul(time, hn::Add(hn::Set(d, m.turn), hn::Mul(hn::Set(d, m.aside), nearness)));
    const Vf across = hn::Min(hn::Max(lines, hn::Set(d, -m.most)), hn::Set(d, m.most));
    const Vf u = movedTo(d, line.u, line.u_before, line.u_after, i, along, across, bounds.least,
                         bounds.most_u);
    const Vf v = movedTo(d, line.v, line.v_before, line.v_after, i, along, across, bounds.least,
                         bounds.most_v);
    const auto iu = hn::ConvertTo(di, u), iv = hn::ConvertTo(di, v);
    const Vf fu = hn::Sub(u, hn::ConvertTo(d, iu)), fv = hn::Sub(v, hn::ConvertTo(d, iv));
    const auto a = hn::ConvertTo(di, hn::Add(hn::Mul(fu, unit), half));
    const auto b = hn::ConvertTo(di, hn::Add(hn::Mul(fv, unit), half));
    const auto ab = hn::ShiftRight<7>(hn::Add(hn::Mul(a, b), hn::Set(di, 64)));
    const auto below = hn::Sub(b, ab), right = hn::Sub(a, ab);
    const auto here = hn::Sub(hn::Sub(all, a), below);
    hn::StoreU(hn::ShiftLeft<1>(hn::Add(hn::Mul(iv, width), iu)), di, offsets + (i - begin));
    hn::StoreU(hn::BitCast(du, hn::Or(hn::Or(here, hn::ShiftLeft<8>(below)),
                                      hn::Or(hn::ShiftLeft<16>(right), hn::ShiftLeft<24>(ab)))),
               du, weights + (i - begin));
  }
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(smooth);
HWY_EXPORT(pair);
HWY_EXPORT(sample);
HWY_EXPORT(plan);

void smooth121(GrayView in, GrayBuffer out) { HWY_DYNAMIC_DISPATCH(smooth)(in, out); }

void pairRows(GrayView in, ImageView<std::uint16_t> out) { HWY_DYNAMIC_DISPATCH(pair)(in, out); }

void samplePlan(ImageView<const std::uint16_t> pairs, const std::int32_t* offsets,
                const std::uint32_t* weights, const std::uint16_t* gains, int count,
                std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(sample)
  (reinterpret_cast<const std::uint8_t*>(pairs.data), offsets, weights, gains, count, out);
}

void movedPlan(const RawLine& line, const MovedRows& moved, const RawBounds& bounds, int begin,
               int end, std::int32_t* offsets, std::uint32_t* weights) {
  HWY_DYNAMIC_DISPATCH(plan)(line, moved, bounds, begin, end, offsets, weights);
}
}  // namespace ipm_mapping::kernels
#endif
