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

/// The four neighbours of every position: p on its line, q on the next, 1 a row on.
struct Neighbours {
  Vf p0, p1, q0, q1;
};

HWY_INLINE Vf byteOf(Floats d, hn::Vec<Ints> word) {
  return hn::ConvertTo(d, hn::And(word, hn::Set(Ints(), 255)));
}

HWY_INLINE Vf consecutive(Floats d, const std::uint8_t* from) {
  const hn::Rebind<std::uint8_t, Ints> bytes;
  return hn::ConvertTo(d, hn::PromoteTo(Ints(), hn::LoadU(bytes, from)));
}

/// A sway stretches a line so little that a vector's rows are nearly always consecutive.
HWY_INLINE Neighbours neighbours(Floats d, ImageView<const std::uint8_t> image, hn::Vec<Ints> rows,
                                 hn::Vec<Ints> lines) {
  const Ints di;
  const auto row = hn::GetLane(rows), line = hn::GetLane(lines);
  if (hn::AllTrue(di, hn::And(hn::Eq(rows, hn::Iota(di, row)), hn::Eq(lines, hn::Set(di, line))))) {
    const std::uint8_t* p = image.row(line) + row;
    const std::uint8_t* q = p + image.stride;
    return {consecutive(d, p), consecutive(d, p + 1), consecutive(d, q), consecutive(d, q + 1)};
  }
  const auto* base = reinterpret_cast<const std::int32_t*>(image.data);
  const auto stride = hn::Set(di, static_cast<std::int32_t>(image.stride));
  const auto offset = hn::Add(hn::Mul(lines, stride), rows);
  const auto p = hn::GatherOffset(di, base, offset);
  const auto q = hn::GatherOffset(di, base, hn::Add(offset, stride));
  return {byteOf(d, p), byteOf(d, hn::ShiftRight<8>(p)), byteOf(d, q),
          byteOf(d, hn::ShiftRight<8>(q))};
}

void sway(ImageView<const std::uint8_t> image, int line, const SwayShift& shift, int begin, int end,
          std::uint8_t* HWY_RESTRICT out) {
  const Floats d;
  const Ints di;
  const hn::Rebind<std::uint8_t, Ints> bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Vf first_row = hn::Set(d, static_cast<float>(begin));
  const Vf last_row = hn::Set(d, static_cast<float>(end - 1));
  const Vf last_line = hn::Set(d, static_cast<float>(image.height - 1));
  const Vf along = hn::Set(d, shift.along), across = hn::Set(d, shift.across);
  for (int row = begin; row < end; row += lanes) {
    const Vf here = hn::Iota(d, static_cast<float>(row));
    const Vf to = hn::Add(here, hn::Mul(along, hn::LoadU(d, shift.stretch + row)));
    const Vf beside =
        hn::Add(hn::Set(d, static_cast<float>(line)), hn::Mul(across, hn::LoadU(d, shift.r + row)));
    const Vf r = hn::Min(hn::Max(to, first_row), last_row);
    const Vf l = hn::Min(hn::Max(beside, hn::Zero(d)), last_line);
    const auto ir = hn::Min(hn::ConvertTo(di, r), hn::Set(di, end - 2));
    const auto il = hn::Min(hn::ConvertTo(di, l), hn::Set(di, image.height - 2));
    const Vf a = hn::Sub(r, hn::ConvertTo(d, ir)), b = hn::Sub(l, hn::ConvertTo(d, il));
    const Neighbours n = neighbours(d, image, ir, il);
    const Vf near = hn::Add(n.p0, hn::Mul(a, hn::Sub(n.p1, n.p0)));
    const Vf next = hn::Add(n.q0, hn::Mul(a, hn::Sub(n.q1, n.q0)));
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
