#pragma once
// Sums along and across the lines of a rectified view: means of blocks and of upright patches.

#include <cstdint>

namespace ipm_mapping::kernels {

/// sums[b] += in[8 b] + ... + in[8 b + 7] for 8 * blocks bytes.
void addBlockSums(const std::uint8_t* in, int blocks, std::int32_t* sums);

/// column[i] += sign * line[i].
void addLineTo(const std::int16_t* line, int sign, int count, std::int32_t* column);

/// sums[i] = the first i values of column together; count + 1 of them.
void prefixSums(const std::int32_t* column, int count, std::int32_t* sums);

}  // namespace ipm_mapping::kernels
