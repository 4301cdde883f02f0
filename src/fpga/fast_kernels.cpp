#include "ipm_mapping/fpga/fast_kernels.hpp"

#include "fast_segmentation_body.hpp"

// One set of functions per instruction set around the same inlined bodies. No set contracts
// multiply and add (the build forbids it), so that all of them give the same bits.
#define FPGA_KERNEL_SET(NAME, TARGET)                                                           \
  namespace NAME {                                                                              \
  TARGET void homography(const HomographyRow& h, int width, CoordinateRow& row) {               \
    body::homography(h, width, row);                                                            \
  }                                                                                             \
  TARGET void wideHomography(const WideHomography& h, int width, CoordinateRow& row) {          \
    body::wideHomography(h, width, row);                                                        \
  }                                                                                             \
  TARGET void lens(const LensConstants& c, int width, CoordinateRow& row, LensCounts& counts) { \
    body::lens(c, width, row, counts);                                                          \
  }                                                                                             \
  TARGET std::int64_t address(const AddressConstants& c, int width, const CoordinateRow& row,   \
                              std::int32_t* offsets) {                                          \
    return body::address(c, width, row, offsets);                                               \
  }                                                                                             \
  TARGET void difference(const std::uint8_t* reference, const std::int32_t* offsets,            \
                         const std::uint8_t* current, const std::uint8_t* current_valid,        \
                         int width, std::uint8_t* out, std::uint8_t* valid) {                   \
    body::difference(reference, offsets, current, current_valid, width, out, valid);            \
  }                                                                                             \
  TARGET void gaussian(const std::uint8_t* above, const std::uint8_t* row,                      \
                       const std::uint8_t* below, const std::uint8_t* valid, int width,         \
                       std::uint8_t* out) {                                                     \
    body::gaussian(above, row, below, valid, width, out);                                       \
  }                                                                                             \
  TARGET void binarise(const std::uint8_t* gaussian, int threshold, int width, BitRow& bits) {  \
    body::binarise(gaussian, threshold, width, bits);                                           \
  }                                                                                             \
  TARGET std::int64_t localize(const MachineConstants& c, int v, LineRegisters& registers) {    \
    return body::localize(c, v, registers);                                                     \
  }                                                                                             \
  constexpr FastKernels set{#NAME,      homography, wideHomography, lens,    address,           \
                            difference, gaussian,   binarise,       localize};                  \
  }

namespace ipm_mapping::fpga {
namespace {

FPGA_KERNEL_SET(plain, )
#if defined(__x86_64__) && defined(__GNUC__)
FPGA_KERNEL_SET(avx2, __attribute__((target("avx2"))))
FPGA_KERNEL_SET(avx512, __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl"))))
#endif

std::vector<const FastKernels*> detect() {
  std::vector<const FastKernels*> sets{&plain::set};
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) sets.push_back(&avx2::set);
  if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl")) {
    sets.push_back(&avx512::set);
  }
#endif
  return sets;
}

}  // namespace

const std::vector<const FastKernels*>& supportedKernels() {
  static const std::vector<const FastKernels*> sets = detect();
  return sets;
}

}  // namespace ipm_mapping::fpga
