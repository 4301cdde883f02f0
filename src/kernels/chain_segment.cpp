#include "ipm_mapping/kernels/chain_segment.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/chain_segment.cpp"
#include "hwy/foreach_target.h"
// foreach_target.h has to come first.
#include "hwy/highway.h"

// Every function is a vector loop with the plain loop behind it for the row's tail. Without vector
// instructions the plain loop does it all: it is the definition.
HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::ScalableTag<std::uint8_t>;
using Words = hn::ScalableTag<std::uint16_t>;
using HalfBytes = hn::Rebind<std::uint8_t, Words>;
using hn::LoadU;
using hn::StoreU;

constexpr bool vectors = HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR;
template <class Tag>
HWY_INLINE int Step(Tag d) {
  return static_cast<int>(hn::Lanes(d));
}

HWY_ATTR void DifferenceRow(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* valid,
                            int width, std::uint8_t* out) {
  const Bytes d;
  int u = 0;
  for (; vectors && u + Step(d) <= width; u += Step(d)) {
    const auto pa = LoadU(d, a + u), pb = LoadU(d, b + u);
    const auto difference = hn::Sub(hn::Max(pa, pb), hn::Min(pa, pb));
    StoreU(hn::And(difference, LoadU(d, valid + u)), d, out + u);
  }
  for (; u < width; ++u)
    out[u] = static_cast<std::uint8_t>((std::max(a[u], b[u]) - std::min(a[u], b[u])) & valid[u]);
}

HWY_ATTR void ColumnSums(const std::uint8_t* above, const std::uint8_t* here,
                         const std::uint8_t* below, int width, std::uint16_t* sums) {
  const Words d;
  const HalfBytes bytes;
  int u = 0;
  for (; vectors && u + Step(d) <= width; u += Step(d)) {
    const auto twice = hn::ShiftLeft<1>(hn::PromoteTo(d, LoadU(bytes, here + u)));
    const auto outer = hn::Add(hn::PromoteTo(d, LoadU(bytes, above + u)),
                               hn::PromoteTo(d, LoadU(bytes, below + u)));
    StoreU(hn::Add(twice, outer), d, sums + u);
  }
  for (; u < width; ++u) sums[u] = static_cast<std::uint16_t>(above[u] + 2 * here[u] + below[u]);
}

HWY_ATTR void BlurRow(const std::uint8_t* above, const std::uint8_t* here,
                      const std::uint8_t* below, const std::uint8_t* valid, int width,
                      std::uint16_t* sums, std::uint8_t* out, std::uint8_t* seen) {
  ColumnSums(above, here, below, width, sums);
  const hn::RebindToSigned<Words> d;
  const Words du;
  const HalfBytes bytes;
  int u = 1;
  for (; vectors && u + Step(d) < width; u += Step(d)) {
    const auto twice = hn::ShiftLeft<1>(LoadU(du, sums + u));
    const auto outer = hn::Add(LoadU(du, sums + u - 1), LoadU(du, sums + u + 1));
    const auto rounded = hn::Add(hn::Add(twice, outer), hn::Set(du, std::uint16_t{8}));
    const auto grey = hn::DemoteTo(bytes, hn::BitCast(d, hn::ShiftRight<4>(rounded)));
    const auto centre = LoadU(bytes, valid + u);
    StoreU(hn::And(grey, centre), bytes, out + u);
    StoreU(centre, bytes, seen + u);
  }
  for (; u < width - 1; ++u) {
    const int grey = (sums[u - 1] + 2 * sums[u] + sums[u + 1] + 8) >> 4;
    out[u] = static_cast<std::uint8_t>(grey & valid[u]);
    seen[u] = valid[u];
  }
  out[0] = out[width - 1] = seen[0] = seen[width - 1] = 0;
}

HWY_ATTR void BinarizeRow(const std::uint8_t* grey, const std::uint8_t* valid, int threshold,
                          int width, std::uint8_t* out) {
  const Bytes d;
  const auto level = static_cast<std::uint8_t>(threshold);
  int u = 0;
  for (; vectors && u + Step(d) <= width; u += Step(d)) {
    const auto above = hn::VecFromMask(d, hn::Gt(LoadU(d, grey + u), hn::Set(d, level)));
    StoreU(hn::And(above, LoadU(d, valid + u)), d, out + u);
  }
  for (; u < width; ++u) out[u] = static_cast<std::uint8_t>((grey[u] > level ? 255 : 0) & valid[u]);
}

HWY_ATTR void ErodeRow(const std::uint8_t* above, const std::uint8_t* here,
                       const std::uint8_t* below, int width, std::uint8_t* columns,
                       std::uint8_t* out) {
  const Bytes d;
  int u = 0;
  for (; vectors && u + Step(d) <= width; u += Step(d)) {
    const auto outer = hn::And(LoadU(d, above + u), LoadU(d, below + u));
    StoreU(hn::And(outer, LoadU(d, here + u)), d, columns + u);
  }
  for (; u < width; ++u) columns[u] = static_cast<std::uint8_t>(above[u] & here[u] & below[u]);
  u = 1;
  for (; vectors && u + Step(d) < width; u += Step(d)) {
    const auto outer = hn::And(LoadU(d, columns + u - 1), LoadU(d, columns + u + 1));
    StoreU(hn::And(outer, LoadU(d, columns + u)), d, out + u);
  }
  for (; u < width - 1; ++u)
    out[u] = static_cast<std::uint8_t>(columns[u - 1] & columns[u] & columns[u + 1]);
  out[0] = out[width - 1] = 0;
}

HWY_ATTR void ComposeMaskRow(const std::uint8_t* eroded, const std::uint8_t* valid, int width,
                             std::uint8_t* out) {
  const Bytes d;
  const std::uint8_t unseen = 128;
  int u = 0;
  for (; vectors && u + Step(d) <= width; u += Step(d)) {
    const auto hidden = hn::AndNot(LoadU(d, valid + u), hn::Set(d, unseen));
    StoreU(hn::Or(LoadU(d, eroded + u), hidden), d, out + u);
  }
  for (; u < width; ++u) out[u] = static_cast<std::uint8_t>(eroded[u] | (unseen & ~valid[u]));
}

HWY_ATTR int CountNonZero(const std::uint8_t* bytes, int width) {
  const Bytes d;
  int u = 0, zeros = 0;
  for (; vectors && u + Step(d) <= width; u += Step(d))
    zeros += static_cast<int>(hn::CountTrue(d, hn::Eq(LoadU(d, bytes + u), hn::Zero(d))));
  for (; u < width; ++u) zeros += bytes[u] == 0;
  return width - zeros;
}

}  // namespace HWY_NAMESPACE
}  // namespace ipm_mapping::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {

HWY_EXPORT(DifferenceRow);
HWY_EXPORT(BlurRow);
HWY_EXPORT(BinarizeRow);
HWY_EXPORT(ErodeRow);
HWY_EXPORT(ComposeMaskRow);
HWY_EXPORT(CountNonZero);

void differenceRow(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* valid,
                   int width, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(DifferenceRow)(a, b, valid, width, out);
}
void blurRow(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
             const std::uint8_t* valid, int width, std::uint16_t* scratch, std::uint8_t* out,
             std::uint8_t* seen) {
  HWY_DYNAMIC_DISPATCH(BlurRow)(above, here, below, valid, width, scratch, out, seen);
}
void binarizeRow(const std::uint8_t* grey, const std::uint8_t* valid, int threshold, int width,
                 std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(BinarizeRow)(grey, valid, threshold, width, out);
}
void erodeRow(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
              int width, std::uint8_t* scratch, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ErodeRow)(above, here, below, width, scratch, out);
}
void composeMaskRow(const std::uint8_t* eroded, const std::uint8_t* valid, int width,
                    std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ComposeMaskRow)(eroded, valid, width, out);
}
int countNonZero(const std::uint8_t* bytes, int width) {
  return HWY_DYNAMIC_DISPATCH(CountNonZero)(bytes, width);
}

}  // namespace ipm_mapping::kernels
#endif
