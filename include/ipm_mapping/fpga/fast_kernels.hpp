#pragma once
// Row kernels of the fast engine. They hold no state and give the bits of the staged twins on
// every instruction set; the compiler vectorises one plain body for each of them.

#include <cstdint>
#include <vector>

#include "ipm_mapping/fpga/formats.hpp"

namespace ipm_mapping::fpga {

/// Elements of a row buffer: the widest row, and room for what a vector reads past it.
inline constexpr int row_capacity = max_width + 64;

/// 12.6 coordinates of a row with their validity (-1 or 0).
struct CoordinateRow {
  alignas(64) std::int32_t x[row_capacity];
  alignas(64) std::int32_t y[row_capacity];
  alignas(64) std::int32_t valid[row_capacity];
};

/// Numerators, denominator and horizon at column 0 of a row, and what one column adds (rule 3).
struct HomographyRow {
  std::int32_t nx, ny, d, horizon;
  std::int32_t nx_step, ny_step, d_step, horizon_step;
};

/// Coefficients of paper_order, which multiplies 12.6 coordinates (rule 4).
struct WideHomography {
  std::int64_t h[9];
};

/// Rule 4 with everything that does not change within a frame worked out.
struct LensConstants {
  std::int32_t fx, fy, cx, cy;
  std::int32_t k1, k2, k3;  ///< 16 fraction bits
  std::int32_t r2_max;
  float x_scale, y_scale;  ///< 65536 / f
  bool narrow;             ///< every intermediate of a valid pixel fits 32 bits
};

struct LensCounts {
  std::int64_t xn = 0, yn = 0;
};

/// Rule 5.
struct AddressConstants {
  std::int32_t width, height, stride;
  std::int32_t near_write_below;  ///< a valid vi below this is a read_write hit
};

/// Registers of the 80 lines, one array each (rules 11 and 12).
struct LineRegisters {
  alignas(64) std::int32_t u[line_count], d[line_count];
  alignas(64) std::int32_t direction[line_count], up[line_count], flat[line_count];
  alignas(64) std::int32_t bear[line_count];
  alignas(64) std::int32_t smallest[line_count], score[line_count], height[line_count],
      surface[line_count];
  alignas(64) std::int32_t stored[line_count], found[line_count];
  alignas(64) std::int32_t window[line_count];
};

struct MachineConstants {
  std::int32_t score_min, min_height;
  bool triangle;
};

/// Words of a row of mask bits with a word of zeros on either side; pixel u is bit u + 64.
inline constexpr int bit_words = max_width / 64 + 3;
struct BitRow {
  alignas(64) std::uint64_t words[bit_words];
};

/// Value of a Gaussian pixel without correspondence: rule 8 never puts out more than 247.
inline constexpr std::uint8_t invalid_grey = 255;

struct FastKernels {
  const char* name;
  /// Rules 3-5 of a row: offsets into the reference frame (0 where there is none), validity (255
  /// or 0), saturations of valid pixels. Returns the read_write hits.
  std::int64_t (*warp)(const HomographyRow&, const LensConstants&, const AddressConstants&,
                       CoordinateRow& scratch, std::int32_t* offsets, std::uint8_t* valid,
                       LensCounts&);
  /// Rule 3 in paper_order, in place.
  void (*wide_homography)(const WideHomography&, int width, CoordinateRow&);
  /// Rule 4 in place; counts saturations of valid pixels.
  void (*lens)(const LensConstants&, int width, CoordinateRow&, LensCounts&);
  /// Rule 5 alone, as in warp.
  std::int64_t (*address)(const AddressConstants&, const CoordinateRow&, std::int32_t* offsets,
                          std::uint8_t* valid);
  /// Rule 7: differences, 0 where invalid; valid holds the reference's validity, then both'.
  void (*difference)(const std::uint8_t* reference, const std::int32_t* offsets,
                     const std::uint8_t* current, const std::uint8_t* current_valid, int width,
                     std::uint8_t* out, std::uint8_t* valid);
  /// Rule 8, an inner row.
  void (*gaussian)(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below,
                   const std::uint8_t* valid, int width, std::uint8_t* out);
  /// Rule 9: the mask of a row of Gaussian pixels as bits.
  void (*binarise)(const std::uint8_t* gaussian, int threshold, int width, BitRow&);
  /// Rules 11 and 12: an eroded row for all lines, then the Bresenham step. Returns the
  /// saturations of D.
  std::int64_t (*localize)(const MachineConstants&, int v, const BitRow& eroded, LineRegisters&);
};

/// Kernel sets that this processor can run, plainest first.
[[nodiscard]] const std::vector<const FastKernels*>& supportedKernels();

}  // namespace ipm_mapping::fpga
