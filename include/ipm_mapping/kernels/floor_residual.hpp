#pragma once
// Bodies of the floor cost: how unlike the floor of the reference the current image is. Units and
// constants are those of sweep_costs.hpp, and every SIMD target gives the same numbers.

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::kernels {

/// out[i] = ((8 - t) a[i] + t b[i]) / 8: nodes of a line between two lines of nodes.
void blendNodes(const std::int32_t* a, const std::int32_t* b, std::int32_t t, int count,
                std::int32_t* out);

/// Positions on a path: out[8 b + k] = (node[b] (8 - k) + node[b + 1] k) >> 7, nodes in 1/1024,
/// positions in 1/64. `out` holds 8 * blocks values.
void interpolateNodes(const std::int32_t* nodes, int blocks, std::int32_t* out);

/// Bilinear samples on a path through the reference, minus the current line:
///   residual[i] = current[i] - ((gain * sample + 32 * offset) >> 14)
/// where the sample, in 1/32 grey levels, lies at row[i] and line[i], both in 1/64. `pairs` is
/// pairRows() of the rectified reference: the four neighbours of a sample are one word.
void pathResidual(ImageView<const std::uint16_t> pairs, const std::int32_t* row,
                  const std::int32_t* line, std::int32_t gain, std::int32_t offset,
                  const std::int16_t* current, int count, std::int16_t* residual);

/// sum[i] += residual[i], number[i] += 1; `sign` -1 takes them away again.
void accumulateResidual(const std::int16_t* residual, int sign, int count, std::int32_t* sum,
                        std::int32_t* number);

/// mean[i] = sum over a window of `width` rows from i on / number over it, of which `sums` and
/// `numbers` are prefixSums(); 0 where the window is empty.
void windowMean(const std::int32_t* sums, const std::int32_t* numbers, int width, int count,
                std::int16_t* mean);

/// squares[i] = t^2 with t = min(|e| weight / 2^16, cap), e the smaller of the residual and the
/// residual minus mean[i].
void squaredFloorDeviation(const std::int16_t* residual, const std::int16_t* mean,
                           const std::uint16_t* weight, int count, std::uint16_t* squares);

/// cost[i] += squares[i]
void addSquares(const std::uint16_t* squares, int count, std::uint16_t* cost);

}  // namespace ipm_mapping::kernels
