#pragma once
// One row of the segmentation's pixel work, on the best instruction set of the machine. Integer
// arithmetic: every instruction set gives the same bits.

#include <array>
#include <cstdint>

namespace ipm_mapping::kernels {

/// |a - b| where valid, else 0. valid: 255 or 0.
void differenceRow(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* valid,
                   int width, std::uint8_t* out);

/// [1 2 1; 2 4 2; 1 2 1] / 16, rounded to nearest, of pixels 1 ... width - 2 where valid; 0
/// elsewhere. seen: valid without the first and the last pixel. Rows have at least one pixel.
/// scratch: `width`.
void blurRow(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
             const std::uint8_t* valid, int width, std::uint16_t* scratch, std::uint8_t* out,
             std::uint8_t* seen);

/// 255 where grey > threshold (0 ... 255) and valid, else 0.
void binarizeRow(const std::uint8_t* grey, const std::uint8_t* valid, int threshold, int width,
                 std::uint8_t* out);

/// AND of the 3x3 neighbourhood of pixels 1 ... width - 2; 0 on the first and the last.
/// scratch: `width`.
void erodeRow(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
              int width, std::uint8_t* scratch, std::uint8_t* out);

/// eroded and valid (255 or 0) to 255 (obstacle), 0 (floor: valid) or 128 (unseen).
void composeMaskRow(const std::uint8_t* eroded, const std::uint8_t* valid, int width,
                    std::uint8_t* out);

/// How many bytes are not 0.
int countNonZero(const std::uint8_t* bytes, int width);

}  // namespace ipm_mapping::kernels
