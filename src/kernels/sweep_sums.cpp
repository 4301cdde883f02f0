#include "ipm_mapping/kernels/sweep_sums.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/sweep_sums.cpp"
#include "hwy/foreach_target.h"
// After foreach_target.
#include "hwy/highway.h"

// Plain integer loops are left to the compiler, which vectorises them for the target at hand.
HWY_BEFORE_NAMESPACE();
namespace ipm_mapping::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void blockSums(const std::uint8_t* HWY_RESTRICT in, int blocks, std::int32_t* HWY_RESTRICT sums) {
  for (int b = 0; b < blocks; ++b) {
    std::int32_t sum = 0;
    for (int k = 0; k < 8; ++k) sum += in[8 * b + k];
    sums[b] += sum;
  }
}

void addLine(const std::int16_t* HWY_RESTRICT line, std::int32_t sign, int count,
             std::int32_t* HWY_RESTRICT column) {
  for (int i = 0; i < count; ++i) column[i] += sign * line[i];
}

void prefixes(const std::int32_t* HWY_RESTRICT column, int count, std::int32_t* HWY_RESTRICT sums) {
  sums[0] = 0;
  int i = 0;
  std::int32_t total = 0;
#if HWY_TARGET != HWY_SCALAR
  // four at a time: only the carry waits for what came before
  const hn::FixedTag<std::int32_t, 4> d;
  auto carry = hn::Zero(d);
  for (; i + 4 <= count; i += 4) {
    const auto here = hn::LoadU(d, column + i);
    const auto pairs = hn::Add(here, hn::ShiftLeftLanes<1>(d, here));
    const auto upTo = hn::Add(pairs, hn::ShiftLeftLanes<2>(d, pairs));
    hn::StoreU(hn::Add(upTo, carry), d, sums + i + 1);
    carry = hn::Add(carry, hn::Broadcast<3>(upTo));
  }
  total = hn::GetLane(carry);
#endif
  for (; i < count; ++i) sums[i + 1] = total += column[i];
}

}  // namespace ipm_mapping::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ipm_mapping::kernels {
HWY_EXPORT(blockSums);
HWY_EXPORT(addLine);
HWY_EXPORT(prefixes);

void addBlockSums(const std::uint8_t* in, int blocks, std::int32_t* sums) {
  HWY_DYNAMIC_DISPATCH(blockSums)(in, blocks, sums);
}

void addLineTo(const std::int16_t* line, int sign, int count, std::int32_t* column) {
  HWY_DYNAMIC_DISPATCH(addLine)(line, sign, count, column);
}

void prefixSums(const std::int32_t* column, int count, std::int32_t* sums) {
  HWY_DYNAMIC_DISPATCH(prefixes)(column, count, sums);
}
}  // namespace ipm_mapping::kernels
#endif
