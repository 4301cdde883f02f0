#pragma once
// Integer bodies of the cylindrical rectification: exact, so every SIMD target gives the same
// bytes.

#include <cstdint>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::kernels {

/// out = ((1 2 1) x (1 2 1) * in + 8) >> 4; pixels outside the image repeat its border.
/// Same size, at least 1x1; `in` and `out` do not overlap.
void smooth121(GrayView in, GrayBuffer out);

/// out(u, v) = in(u, v) | in(u, v + 1) << 8; the last row pairs with itself. The bytes of two
/// neighbouring pairs are the 2x2 neighbourhood that a bilinear sample needs.
void pairRows(GrayView in, ImageView<std::uint16_t> out);

/// Raw pixels that see the rows of a line, and of the lines before and after it.
struct RawLine {
  const float *u = nullptr, *v = nullptr;
  const float *u_before = nullptr, *v_before = nullptr;
  const float *u_after = nullptr, *v_after = nullptr;
};
/// How the rows of a line are moved that were read t = v read_per_pixel - 1/2 after the stamp:
///   t ahead nearness[row] rows,   t (turn + aside nearness[row]) lines,
/// at most `most_rows` and `most`.
struct MovedRows {
  const float* nearness = nullptr;
  float ahead = 0.0F, turn = 0.0F, aside = 0.0F, most = 0.0F, most_rows = 0.0F;
};
/// The image that is sampled: pixels stay within [least, most_u] x [least, most_v].
struct RawBounds {
  float least = 0.0F, most_u = 0.0F, most_v = 0.0F, read_per_pixel = 0.0F;
  int width = 0;
};
/// Plan for samplePlan() of rows begin ... end - 1 of a moved line, linear in rows and lines: rows
/// begin - 1 and end are read too. Entry i of the plan is row begin + i; up to `overrun` more are
/// written. Weights are products of fractions in 1/128.
void movedPlan(const RawLine& line, const MovedRows& moved, const RawBounds& bounds, int begin,
               int end, std::int32_t* offsets, std::uint32_t* weights);

constexpr std::uint16_t no_gain = 1 << 14;

/// out[i] = min((gains[i] sum over k of byte k of the 4 bytes at pairs + offsets[i] times byte k of
/// weights[i] + 2^20) >> 21, 255): gains in 1 / no_gain. The weights of one sample sum to 128;
/// every 4 bytes lie inside the pair image.
void samplePlan(ImageView<const std::uint16_t> pairs, const std::int32_t* offsets,
                const std::uint32_t* weights, const std::uint16_t* gains, int count,
                std::uint8_t* out);

}  // namespace ipm_mapping::kernels
