#include "ipm_mapping/kernels/sweep_alignment.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sweep_alignment.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "sweep_math_body.hpp"

void project(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, int count,
             const FloorProjection& f, const SamplePositions& out) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Vf c = hn::Set(d, f.c), s = hn::Set(d, f.s), minus_s = hn::Set(d, -f.s);
  const Vf foot_x = hn::Set(d, f.foot_x), foot_y = hn::Set(d, f.foot_y);
  const Vf rows = hn::Set(d, f.rows_per_log), lines = hn::Set(d, f.lines_per_radian);
  for (int i = 0; i < count; i += lanes) {
    const Vf X = hn::LoadU(d, x + i), Y = hn::LoadU(d, y + i);
    const Vf px = hn::Add(sumOfProducts(c, X, minus_s, Y), hn::Set(d, f.tx));
    const Vf py = hn::Add(sumOfProducts(s, X, c, Y), hn::Set(d, f.ty));
    const Vf d2 = hn::Max(sumOfProducts(px, px, py, py), hn::Set(d, 1e-12F));
    const Vf half_log = hn::Mul(hn::Set(d, 0.5F), logarithm(d, d2));
    hn::StoreU(hn::Sub(hn::Set(d, f.row_at_one), hn::Mul(rows, half_log)), d, out.row + i);
    hn::StoreU(hn::Sub(hn::Set(d, f.line_ahead), hn::Mul(lines, angle(d, px, py))), d,
               out.line + i);
    // d row = -rows (p . dp) / |p|^2, d line = -lines (p x dp) / |p|^2; by theta dp is the base's
    // point turned by a right angle
    const Vf bx = hn::Add(foot_x, X), by = hn::Add(foot_y, Y);
    const Vf turned_x = sumOfProducts(minus_s, bx, hn::Neg(c), by);
    const Vf turned_y = sumOfProducts(c, bx, minus_s, by);
    const Vf by_row = hn::Div(hn::Neg(rows), d2), by_line = hn::Div(hn::Neg(lines), d2);
    hn::StoreU(hn::Mul(by_row, px), d, out.d_row[0] + i);
    hn::StoreU(hn::Mul(by_row, py), d, out.d_row[1] + i);
    hn::StoreU(hn::Mul(by_row, sumOfProducts(px, turned_x, py, turned_y)), d, out.d_row[2] + i);
    hn::StoreU(hn::Mul(by_line, hn::Neg(py)), d, out.d_line[0] + i);
    hn::StoreU(hn::Mul(by_line, px), d, out.d_line[1] + i);
    hn::StoreU(hn::Mul(by_line, sumOfProducts(px, turned_y, hn::Neg(py), turned_x)), d,
               out.d_line[2] + i);
    // With r = height / |p|: a pitch turns r by (1 + r^2) cos(azimuth) and the azimuth by
    // r sin(azimuth), a roll the same a right angle on.
    const Vf height = hn::Set(d, f.height);
    const Vf by_tilt = hn::Mul(by_row, hn::Add(hn::Div(d2, height), height));
    const Vf by_twist = hn::Neg(hn::Mul(by_line, height));
    hn::StoreU(hn::Mul(by_tilt, px), d, out.d_row[3] + i);
    hn::StoreU(hn::Neg(hn::Mul(by_tilt, py)), d, out.d_row[4] + i);
    hn::StoreU(hn::Mul(by_twist, py), d, out.d_line[3] + i);
    hn::StoreU(hn::Mul(by_twist, px), d, out.d_line[4] + i);
  }
}

/// A position moved by the correction and kept within [0, last].
HWY_INLINE Vf moved(Floats d, const float* position, const float* const* by,
                    const float* correction, int i, float last) {
  Vf at = hn::LoadU(d, position + i);
  for (int k = 0; k < alignment_moves; ++k)
    at = hn::Add(at, hn::Mul(hn::LoadU(d, by[k] + i), hn::Set(d, correction[k])));
  return hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, last));
}

void warp(ImageView<const std::uint8_t> reference, const SamplePositions& at,
          const float* HWY_RESTRICT mean, const float* correction, int count,
          const WarpedSamples& out) {
  const Floats d;
  const Ints di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto* base = reinterpret_cast<const std::int32_t*>(reference.data);
  const auto stride = hn::Set(di, static_cast<std::int32_t>(reference.stride));
  const auto byte = hn::Set(di, 255);
  const float last_row = static_cast<float>(reference.width) - 1.01F;
  const float last_line = static_cast<float>(reference.height) - 1.01F;
  for (int i = 0; i < count; i += lanes) {
    const Vf r = moved(d, at.row, at.d_row, correction, i, last_row);
    const Vf l = moved(d, at.line, at.d_line, correction, i, last_line);
    const auto ir = hn::ConvertTo(di, r), il = hn::ConvertTo(di, l);
    const Vf a = hn::Sub(r, hn::ConvertTo(d, ir)), b = hn::Sub(l, hn::ConvertTo(d, il));
    const auto offset = hn::Add(hn::Mul(il, stride), ir);
    const auto p = hn::GatherOffset(di, base, offset);
    const auto q = hn::GatherOffset(di, base, hn::Add(offset, stride));
    const Vf p0 = hn::ConvertTo(d, hn::And(p, byte)), q0 = hn::ConvertTo(d, hn::And(q, byte));
    const Vf p_step = hn::Sub(hn::ConvertTo(d, hn::And(hn::ShiftRight<8>(p), byte)), p0);
    const Vf q_step = hn::Sub(hn::ConvertTo(d, hn::And(hn::ShiftRight<8>(q), byte)), q0);
    const Vf here = hn::Add(p0, hn::Mul(a, p_step)), next = hn::Add(q0, hn::Mul(a, q_step));
    const Vf by_line = hn::Sub(next, here);
    const Vf by_row = hn::Add(p_step, hn::Mul(b, hn::Sub(q_step, p_step)));
    const Vf grey = hn::Add(here, hn::Mul(b, by_line));
    hn::StoreU(grey, d, out.grey + i);
    hn::StoreU(hn::Sub(grey, hn::LoadU(d, mean + i)), d, out.high + i);
    for (int k = 0; k < alignment_moves; ++k)
      hn::StoreU(sumOfProducts(by_row, hn::LoadU(d, at.d_row[k] + i), by_line,
                               hn::LoadU(d, at.d_line[k] + i)),
                 d, out.gradient[k] + i);
  }
}

using Strands = hn::CappedTag<float, alignment_lanes>;

/// Element k of a row of J.
HWY_INLINE hn::Vec<Strands> regressor(Strands d, const AlignmentResidual& r,
                                      const float* const* gradient, int k, int i) {
  if (k == alignment_moves + 1) return hn::Set(d, 1.0F);
  return hn::LoadU(d, (k == alignment_moves ? r.warped : gradient[k]) + i);
}

HWY_INLINE void add(Strands d, hn::Vec<Strands> term, float* HWY_RESTRICT strands) {
  hn::StoreU(hn::Add(hn::LoadU(d, strands), term), d, strands);
}

/// Adds the samples from i on to the strands from `strand` on; samples beyond the count weigh
/// nothing.
HWY_INLINE void addSamples(const AlignmentResidual& r, const float* const* gradient, float limit,
                           int i, float* HWY_RESTRICT strands) {
  const Strands d;
  using V = hn::Vec<Strands>;
  const V model =
      hn::Add(hn::Mul(hn::Set(d, r.gain), hn::LoadU(d, r.warped + i)), hn::Set(d, r.offset));
  const V e = hn::Sub(hn::LoadU(d, r.current + i), model);
  const V share = hn::Div(e, hn::Set(d, limit));
  const V rest = hn::Max(hn::Sub(hn::Set(d, 1.0F), hn::Mul(share, share)), hn::Zero(d));
  const auto there = hn::FirstN(d, static_cast<std::size_t>(std::max(r.count - i, 0)));
  const V w = hn::IfThenElseZero(there, hn::Mul(rest, rest));
  float* sum = strands + alignment_unknowns * alignment_lanes;
  for (int row = 0; row < alignment_unknowns; ++row) {
    const V weighted = hn::Mul(w, regressor(d, r, gradient, row, i));
    add(d, hn::Mul(weighted, e), strands + row * alignment_lanes);
    for (int column = row; column < alignment_unknowns; ++column, sum += alignment_lanes)
      add(d, hn::Mul(weighted, regressor(d, r, gradient, column, i)), sum);
  }
}

void sums(const AlignmentResidual& residual, const float* const* gradient, float limit,
          double* HWY_RESTRICT out) {
  float strands[alignment_sums * alignment_lanes] = {};
  const int lanes = static_cast<int>(hn::Lanes(Strands()));
  for (int i = 0; i < residual.count; i += alignment_lanes)
    for (int k = 0; k < alignment_lanes; k += lanes)
      addSamples(residual, gradient, limit, i + k, strands + k);
  for (int n = 0; n < alignment_sums; ++n) {
    out[n] = 0.0;
    for (int k = 0; k < alignment_lanes; ++k)
      out[n] += static_cast<double>(strands[n * alignment_lanes + k]);
  }
}

int countUpTo(const float* HWY_RESTRICT values, int count, float most) {
  int n = 0;
  for (int i = 0; i < count; ++i) n += values[i] <= most ? 1 : 0;
  return n;
}

/// By halving the interval: a handful of passes over what the first cache holds.
float median(const AlignmentResidual& r, float most, float* HWY_RESTRICT scratch) {
  constexpr int halvings = 10;
  for (int i = 0; i < r.count; ++i) {
    const float e = r.current[i] - (r.gain * r.warped[i] + r.offset);
    scratch[i] = e < 0.0F ? -e : e;
  }
  float low = 0.0F, high = most;
  for (int k = 0; k < halvings; ++k) {
    const float middle = 0.5F * (low + high);
    (2 * countUpTo(scratch, r.count, middle) > r.count ? high : low) = middle;
  }
  return high;
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(project);
HWY_EXPORT(warp);
HWY_EXPORT(sums);
HWY_EXPORT(median);

void projectFloor(const float* x, const float* y, int count, const FloorProjection& projection,
                  const SamplePositions& out) {
  HWY_DYNAMIC_DISPATCH(project)(x, y, count, projection, out);
}

void warpSamples(ImageView<const std::uint8_t> reference, const SamplePositions& at,
                 const float* mean, const float* correction, int count, const WarpedSamples& out) {
  HWY_DYNAMIC_DISPATCH(warp)(reference, at, mean, correction, count, out);
}

void alignmentSums(const AlignmentResidual& residual, const float* const* gradient, float limit,
                   double* out) {
  HWY_DYNAMIC_DISPATCH(sums)(residual, gradient, limit, out);
}

float medianDeviation(const AlignmentResidual& residual, float most, float* scratch) {
  return HWY_DYNAMIC_DISPATCH(median)(residual, most, scratch);
}
}  // namespace ipm_mapping::kernels
#endif
