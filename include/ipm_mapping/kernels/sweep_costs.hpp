#pragma once
// Bodies of the noise model, the floor cost and the vertical sweep. Grey levels are 16-bit in units
// of 1/32; a deviation t is a difference over its standard deviation in units of 1/16, cut at 48
// (3 sigma); a cost is the sum of t^2 over the 8 lines of a beam, 2048 for a mean of 1 sigma^2.
// All arithmetic is integer, or correctly rounded IEEE: every SIMD target gives the same numbers.

#include <cstdint>

namespace ipm_mapping::kernels {

inline constexpr int grey_unit = 32;
inline constexpr int deviation_cap = 48;
inline constexpr int beam_lines = 8;
inline constexpr int cost_unit = beam_lines * 256;
inline constexpr std::int16_t no_residual = -32768;
inline constexpr std::uint16_t no_cost = 65535;
/// Kernels read and write up to this many elements past `count`.
inline constexpr int overrun = 32;

/// A line of 2 * count bytes to its even and odd rows: (gain * byte + offset) >> 9, cut to
/// [-8191, 8191]. gain 1 is 2^14, less than 2 is expected; an offset of one grey level is 2^14 too.
void splitRows(const std::uint8_t* line, std::int32_t gain, std::int32_t offset, int count,
               std::int16_t* even, std::int16_t* odd);

/// What noiseWeights() needs beside the pixels.
struct NoiseTerms {
  float dark = 0.0F;         ///< variance in the dark, grey levels^2
  float bright = 0.0F;       ///< variance per grey level
  float across = 0.0F;       ///< weight of (I(line + 1) - I(line - 1))^2
  float bend_across = 0.0F;  ///< weight of the second difference over lines
};
/// Grey levels at and around a run of sweep rows, each at the first of them.
struct NoiseNeighbours {
  const std::int16_t* here = nullptr;
  const std::int16_t* left = nullptr;   ///< line before
  const std::int16_t* right = nullptr;  ///< line after
  const std::int16_t* far = nullptr;    ///< fine row - stride
  const std::int16_t* near = nullptr;   ///< fine row + stride
};
/// weight[i] = 32768 / sqrt(variance of sweep row i) for sweep rows i of one line:
///   variance = dark + bright I + across (I(line + 1) - I(line - 1))^2
///            + along[i] (I(row + stride) - I(row - stride))^2
///            + (bend_across (second difference over lines) + bend_along[i] (over rows))^2,
/// at least 0.26. Neighbours are the even or odd rows of splitRows() that hold them.
void noiseWeights(const NoiseNeighbours& grey, const float* along, const float* bend_along,
                  const NoiseTerms& terms, int count, std::uint16_t* weight);

/// One candidate of the vertical sweep: eight lines of the current image against nine lines of the
/// reference, each moved by the same number of rows.
struct VerticalPath {
  const std::int16_t* current = nullptr;  ///< first of eight lines, at the first sweep row
  const std::uint16_t* weight = nullptr;  ///< laid out as `current`
  std::int64_t stride = 0;                ///< elements from line to line, all planes
  const std::int16_t* upper = nullptr;    ///< reference rows at floor(shift), first of nine lines
  const std::int16_t* lower = nullptr;    ///< the rows one further
  std::int16_t row_fraction = 0;          ///< of the shift, 1/2^15
  std::int16_t line_fraction = 0;         ///< of the line position, 1/2^15
  std::int16_t brighter = 0;              ///< than the reference, 1/32 grey levels
};
/// cost[i] = sum over the eight lines of t^2 for sweep rows i < count.
void verticalCost(const VerticalPath& path, int count, std::uint16_t* cost);

/// cost[i] = min(cost[i], other[i] + prior) where cost[i] is not no_cost.
void lowerTo(const std::uint16_t* other, std::int32_t prior, int count, std::uint16_t* cost);

/// evidence[i] += ((min(floor[i], floor_cap) - vertical[i] - prior) * weight[i]) >> 8 where
/// floor[i] is not no_cost: how much better a vertical line explains row i than the floor does.
void accumulateEvidence(const std::uint16_t* floor, const std::uint16_t* vertical,
                        const std::int32_t* weight, std::int32_t floor_cap, std::int32_t prior,
                        int count, std::int32_t* evidence);

/// A candidate in one reference: pointers are at sweep row 0, rows begin ... end - 1 are seen.
struct EvidencePath {
  VerticalPath vertical;
  const std::uint16_t* floor = nullptr;  ///< floor cost
  int begin = 0, end = 0;
};
/// What all references and candidates of a beam have in common, from sweep row 0 on.
struct EvidenceTerms {
  const std::int32_t* weight = nullptr;
  const std::int32_t* potential = nullptr;  ///< what the rows before a row could gain at most
  std::int32_t floor_cap = 0, prior = 0;
};
/// A support on the way up from its contact.
struct Climb {
  std::int32_t sum = 0;   ///< evidence so far
  std::int32_t best = 0;  ///< the highest that the sum has been
  int best_row = 0;       ///< where
  bool over = false;      ///< the rest cannot raise `best`, or cannot raise it to `least`
};
/// Follows a support up the rows end - 1 ... begin, a vector of rows at a time, by verticalCost()
/// and accumulateEvidence() of every reference. The support ends at row `top`, at `begin` or above
/// it.
void climbSupport(const EvidencePath* paths, int count, const EvidenceTerms& terms, int begin,
                  int end, int top, std::int32_t least, Climb& climb);

}  // namespace ipm_mapping::kernels
