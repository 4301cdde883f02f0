#include "ipm_mapping/kernels/sway_line.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sway_line.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "sweep_math_body.hpp"

HWY_INLINE Vf byteOf(Floats d, hn::Vec<Ints> word) {
  return hn::ConvertTo(d, hn::And(word, hn::Set(Ints(), 255)));
}

void sway(ImageView<const std::uint8_t> image, int line, const SwayShift& shift, int begin, int end,
          std::uint8_t* HWY_RESTRICT out) {
  const Floats d;
  const Ints di;
  const hn::Rebind<std::uint8_t, Ints> bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto* base = reinterpret_cast<const std::int32_t*>(image.data);
  const auto stride = hn::Set(di, static_cast<std::int32_t>(image.stride));
  const Vf first_row = hn::Set(d, static_cast<float>(begin));
  const Vf last_row = hn::Set(d, static_cast<float>(end) - 1.01F);
  const Vf last_line = hn::Set(d, static_cast<float>(image.height) - 1.01F);
  const Vf along = hn::Set(d, shift.along), across = hn::Set(d, shift.across);
  for (int row = begin; row < end; row += lanes) {
    const Vf here = hn::Iota(d, static_cast<float>(row));
    const Vf to = hn::Add(here, hn::Mul(along, hn::LoadU(d, shift.stretch + row)));
    const Vf beside =
        hn::Add(hn::Set(d, static_cast<float>(line)), hn::Mul(across, hn::LoadU(d, shift.r + row)));
    const Vf r = hn::Min(hn::Max(to, first_row), last_row);
    const Vf l = hn::Min(hn::Max(beside, hn::Zero(d)), last_line);
    const auto ir = hn::ConvertTo(di, r), il = hn::ConvertTo(di, l);
    const Vf a = hn::Sub(r, hn::ConvertTo(d, ir)), b = hn::Sub(l, hn::ConvertTo(d, il));
    const auto offset = hn::Add(hn::Mul(il, stride), ir);
    const auto p = hn::GatherOffset(di, base, offset);
    const auto q = hn::GatherOffset(di, base, hn::Add(offset, stride));
    const Vf p0 = byteOf(d, p), q0 = byteOf(d, q);
    const Vf near = hn::Add(p0, hn::Mul(a, hn::Sub(byteOf(d, hn::ShiftRight<8>(p)), p0)));
    const Vf next = hn::Add(q0, hn::Mul(a, hn::Sub(byteOf(d, hn::ShiftRight<8>(q)), q0)));
    const Vf grey = hn::Add(near, hn::Mul(b, hn::Sub(next, near)));
    const auto rounded = hn::ConvertTo(di, hn::Add(grey, hn::Set(d, 0.5F)));
    hn::StoreU(hn::DemoteTo(bytes, rounded), bytes, out + row);
  }
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(sway);

void swayLine(ImageView<const std::uint8_t> image, int line, const SwayShift& shift, int begin,
              int end, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(sway)(image, line, shift, begin, end, out);
}
}  // namespace ipm_mapping::kernels
#endif
