#pragma once
// Bodies of the floor cost: how unlike the floor of the reference the current image is. Units and
// constants are those of sweep_costs.hpp, and every SIMD target gives the same numbers.

#include <cstdint>

namespace ipm_mapping::kernels {

/// Positions on a path: out[8 b + k] = (node[b] (8 - k) + node[b + 1] k) >> 7, nodes in 1/1024,
/// positions in 1/64. `out` holds 8 * blocks values.
void interpolateNodes(const std::int32_t* nodes, int blocks, std::int32_t* out);

/// Bilinear samples on a path through the reference, minus the current line:
///   residual[i] = current[i] - ((gain * sample + 32 * offset) >> 14)
/// where the sample, in 1/32 grey levels, lies at row[i] and line[i], both in 1/64. `reference` is
/// the rectified reference, `stride` bytes from line to line.
void pathResidual(const std::uint8_t* reference, std::int32_t stride, const std::int32_t* row,
                  const std::int32_t* line, std::int32_t gain, std::int32_t offset,
                  const std::int16_t* current, int count, std::int16_t* residual);

/// sum[i] += residual[i], number[i] += 1 where the residual is there; `sign` -1 takes it away
/// again.
void accumulateResidual(const std::int16_t* residual, int sign, int count, std::int32_t* sum,
                        std::int32_t* number);

/// prefix[k] = sum of the rows before row k - half, for count + 2 half + 1 values of k.
void prefixSums(const std::int32_t* values, int half, int count, std::int32_t* prefix);

/// mean[i] = sum over the window / number over the window, rows i - half ... i + half of a line's
/// accumulated residuals; 0 where the window is empty. Prefixes are those of
/// prefixSums().
void windowMean(const std::int32_t* sum_prefix, const std::int32_t* number_prefix, int half,
                int count, std::int16_t* mean);

/// squares[i] += t^2 with t = min(|e| weight / 2^16, cap), e the smaller of the residual and the
/// residual minus mean[i]; where the residual is missing squares[i] becomes no_cost and stays it.
void accumulateFloorCost(const std::int16_t* residual, const std::int16_t* mean,
                         const std::uint16_t* weight, int count, std::uint16_t* squares);

}  // namespace ipm_mapping::kernels
