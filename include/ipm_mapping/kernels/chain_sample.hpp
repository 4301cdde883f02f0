#pragma once
// One row of a warp: the raw picture sampled bilinearly, in integers: every instruction set gives
// the same bits.

#include <cstdint>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/chain_samples.hpp"

namespace ipm_mapping::kernels {

/// What sampling a row does to the pixels' validity.
enum class Validity : std::uint8_t {
  Set,  ///< 255 where there is a sample, else 0
  And   ///< kept where there is a sample, else 0
};

/// Samples `width` pixels bilinearly: out = grey level, 0 where there is no sample. The grey level
/// is the exact mean of the four pixels, off by less than 1/32 before it is rounded.
/// scratch: 2 * padded width.
void sampleRow(GrayView raw, const Samples::Row& samples, int width, Validity validity,
               std::uint16_t* scratch, std::uint8_t* out, std::uint8_t* valid);

}  // namespace ipm_mapping::kernels
