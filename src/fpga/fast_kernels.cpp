#include "ipm_mapping/fpga/fast_kernels.hpp"

#include "fast_segmentation_body.hpp"

// One set of functions per instruction set around the same inlined bodies. No set contracts
// multiply and add (the build forbids it), so that all of them give the same bits.
#define FPGA_COMMON_KERNELS()                                                                      \
  void wideHomography(const WideHomography& h, int width, CoordinateRow& row) {                    \
    body::wideHomography(h, width, row);                                                           \
  }                                                                                                \
  void lens(const LensConstants& c, int width, CoordinateRow& row, LensCounts& counts) {           \
    body::lens(c, width, row, counts);                                                             \
  }                                                                                                \
  std::int64_t address(const AddressConstants& c, const CoordinateRow& row, std::int32_t* offsets, \
                       std::uint8_t* valid) {                                                      \
    return body::address(c, row, offsets, valid);                                                  \
  }                                                                                                \
  void difference(const std::uint8_t* reference, const std::int32_t* offsets,                      \
                  const std::uint8_t* current, const std::uint8_t* current_valid, int width,       \
                  std::uint8_t* out, std::uint8_t* valid) {                                        \
    body::difference(reference, offsets, current, current_valid, width, out, valid);               \
  }                                                                                                \
  void gaussian(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below,     \
                const std::uint8_t* valid, int width, std::uint8_t* out) {                         \
    body::gaussian(above, row, below, valid, width, out);                                          \
  }                                                                                                \
  void binarise(const std::uint8_t* gaussian, int threshold, int width, BitRow& bits) {            \
    body::binarise(gaussian, threshold, width, bits);                                              \
  }

#define FPGA_KERNEL_SET(NAME)                                                           \
  constexpr FastKernels set {                                                           \
    NAME, warp, wideHomography, lens, address, difference, gaussian, binarise, localize \
  }

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define FPGA_X86_SETS 1
// GCC 12's own AVX-512 header starts from deliberately undefined registers.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif

namespace ipm_mapping::fpga {
namespace {

namespace plain {
FPGA_COMMON_KERNELS()
std::int64_t warp(const HomographyRow& h, const LensConstants& l, const AddressConstants& a,
                  CoordinateRow& scratch, std::int32_t* offsets, std::uint8_t* valid,
                  LensCounts& counts) {
  return body::warp(h, l, a, scratch, offsets, valid, counts);
}
std::int64_t localize(const MachineConstants& c, int v, const BitRow& bits, LineRegisters& r) {
  return body::localize(c, v, bits, r);
}
FPGA_KERNEL_SET("plain");
}  // namespace plain

#ifdef FPGA_X86_SETS
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#define FPGA_VECTOR_BYTES 32
#define FPGA_MUL_EVEN(a, b) ((U64)_mm256_mul_epi32((__m256i)(a), (__m256i)(b)))
#define FPGA_ANY(mask) (!_mm256_testz_si256((__m256i)(mask), (__m256i)(mask)))
#define FPGA_GATHER(base, offsets) \
  ((I32)_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), (__m256i)(offsets), 1))
#define FPGA_TO_INT(v) ((I32)_mm256_cvttps_epi32((__m256)(v)))
#include "fast_simd_body.hpp"
FPGA_COMMON_KERNELS()
FPGA_KERNEL_SET("avx2");
#undef FPGA_VECTOR_BYTES
#undef FPGA_MUL_EVEN
#undef FPGA_ANY
#undef FPGA_GATHER
#undef FPGA_TO_INT
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl")
namespace avx512 {
#define FPGA_VECTOR_BYTES 64
#define FPGA_MUL_EVEN(a, b) ((U64)_mm512_mul_epi32((__m512i)(a), (__m512i)(b)))
#define FPGA_ANY(mask) (_mm512_test_epi32_mask((__m512i)(mask), (__m512i)(mask)) != 0)
#define FPGA_GATHER(base, offsets) ((I32)_mm512_i32gather_epi32((__m512i)(offsets), base, 1))
#define FPGA_TO_INT(v) ((I32)_mm512_cvttps_epi32((__m512)(v)))
#include "fast_simd_body.hpp"
FPGA_COMMON_KERNELS()
FPGA_KERNEL_SET("avx512");
#undef FPGA_VECTOR_BYTES
#undef FPGA_MUL_EVEN
#undef FPGA_ANY
#undef FPGA_GATHER
#undef FPGA_TO_INT
}  // namespace avx512
#pragma GCC pop_options
#pragma GCC diagnostic pop
#endif

std::vector<const FastKernels*> detect() {
  std::vector<const FastKernels*> sets{&plain::set};
#ifdef FPGA_X86_SETS
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
