#include "ipm_mapping/kernels/chain_warp.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

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

/// The pixel pairs (p, its right neighbour) above and below every sample, the right one in the
/// upper byte.
HWY_ATTR void GatherPairs(GrayView raw, const Samples::Row& samples, int width,
                          std::uint16_t* above, std::uint16_t* below) {
  const auto pair = [](const std::uint8_t* p) {
    return static_cast<std::uint16_t>(p[0] | (p[1] << 8));
  };
  for (int i = 0; i < width; ++i) {
    const std::uint8_t* p = raw.data + samples.v[i] * raw.stride + samples.u[i];
    above[i] = pair(p);
    below[i] = pair(p + raw.stride);
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
