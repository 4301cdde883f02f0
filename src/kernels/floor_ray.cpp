#include "ipm_mapping/kernels/floor_ray.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/floor_ray.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "sweep_math_body.hpp"

void positions(const FloorRay& ray, const float* HWY_RESTRICT inverse, int count,
               float* HWY_RESTRICT line, float* HWY_RESTRICT shift) {
  const Floats d;
  const Vf rows = hn::Set(d, -0.5F * ray.rows_per_log), lines = hn::Set(d, ray.lines_per_radian);
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const Vf near = hn::LoadU(d, inverse + i);
    const Vf x = hn::Add(hn::Set(d, ray.ux), hn::Mul(hn::Set(d, ray.tx), near));
    const Vf y = hn::Add(hn::Set(d, ray.uy), hn::Mul(hn::Set(d, ray.ty), near));
    const Vf square = hn::Max(sumOfProducts(x, x, y, y), hn::Set(d, 1e-12F));
    hn::StoreU(hn::Mul(rows, logarithm(d, square)), d, shift + i);
    hn::StoreU(hn::Sub(hn::Set(d, ray.line_ahead), hn::Mul(lines, angle(d, x, y))), d, line + i);
  }
}

void split(const float* HWY_RESTRICT position, int count, std::int32_t* HWY_RESTRICT whole,
           std::int32_t* HWY_RESTRICT fraction) {
  const Floats d;
  const Ints di;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const Vf x = hn::LoadU(d, position + i);
    const auto towards_zero = hn::ConvertTo(di, x);
    // a mask is -1 where it is true
    const auto above = hn::RebindMask(di, hn::Lt(x, hn::ConvertTo(d, towards_zero)));
    const auto below = hn::Add(towards_zero, hn::VecFromMask(di, above));
    const Vf rest = hn::Sub(x, hn::ConvertTo(d, below));
    hn::StoreU(below, di, whole + i);
    hn::StoreU(hn::ConvertTo(di, hn::Mul(rest, hn::Set(d, 32767.0F))), di, fraction + i);
  }
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(positions);
HWY_EXPORT(split);

void rayPositions(const FloorRay& ray, const float* inverse, int count, float* line, float* shift) {
  HWY_DYNAMIC_DISPATCH(positions)(ray, inverse, count, line, shift);
}

void splitPositions(const float* position, int count, std::int32_t* whole, std::int32_t* fraction) {
  HWY_DYNAMIC_DISPATCH(split)(position, count, whole, fraction);
}
}  // namespace ipm_mapping::kernels
#endif
