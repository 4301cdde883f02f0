#pragma once
// Every wire's format, once. The rule numbers are those of docs/fpga_contract.md; the section
// numbers are the source's.

#include "ipm_mapping/fpga/fixed_point.hpp"

namespace ipm_mapping::fpga {

/// Rule 13: the arrays and buffers are sized for VGA.
inline constexpr int max_width = 640;
inline constexpr int max_height = 480;
/// Rule 11: lines of the beam, and the spacing of their starting columns.
inline constexpr int line_count = 80;
inline constexpr int line_spacing = 8;
/// Rules 14 and 15: entries of Peaks and of the selected points (§6.9, §6.10.1).
inline constexpr int max_peaks = 32;
/// Rule 12: pixels in the window sum on either side of the line.
inline constexpr int window_half_width = 5;
/// Rule 5: rows that the write pointer has to stay behind the read pointer (§6.4).
inline constexpr int read_write_margin = 50;
inline constexpr int address_bits = 19;

namespace formats {

template <int Width, int IntegerBits>
using Coefficient =
    Fixed<Width, IntegerBits, Sign::Signed, Rounding::NearestAway, Overflow::Refuse>;

// Rule 2: coordinates (§6.2.1, §6.2.2).
using Generated = Unsigned<10>;  ///< column or row of the coordinates generator
using GeneratorCoordinate = Fixed<16, 10, Sign::Unsigned>;
using ViewCoordinate = Fixed<18, 12, Sign::Signed, Rounding::TowardZero, Overflow::Refuse>;

// Rule 3: homography (§6.2.2).
using HomographyLinear = Coefficient<18, 7>;   ///< columns 1 and 2: 11 fraction bits
using HomographyOffset = Coefficient<18, 11>;  ///< column 3: 7 fraction bits

// Rule 4: lens (§6.2.2).
using CameraIntrinsic = Fixed<16, 10, Sign::Unsigned, Rounding::NearestAway, Overflow::Refuse>;
using LensCoefficient = Coefficient<14, 3>;
using Normalized = Fixed<20, 4, Sign::Signed, Rounding::TowardZero, Overflow::Saturate>;
using RadiusSquared = Fixed<24, 8, Sign::Unsigned, Rounding::Floor, Overflow::Saturate>;

// Rule 5: address (§6.2.3).
using Column = Unsigned<10, Overflow::Refuse>;
using Row = Unsigned<9, Overflow::Refuse>;
using Address = Unsigned<address_bits>;

// Rules 7 and 8: pixels (§6.4, §6.5). Bit 8 of a tagged pixel says "no correspondence".
using Pixel = Unsigned<8>;

// Rule 9: Otsu (§6.6.1).
using BinCount = Unsigned<19, Overflow::Saturate>;
using GreySum = Unsigned<28, Overflow::Saturate>;
using WeightProduct = Unsigned<38>;
using Variance = Unsigned<54>;

// Rules 10 and 11: focus and beam (§6.8).
using FocusCoordinate = Fixed<14, 14, Sign::Signed, Rounding::NearestAway, Overflow::Refuse>;
using BeamDelta = Unsigned<16>;
using BeamError = Signed<19, Overflow::Saturate>;
using BearingCount = Unsigned<8, Overflow::Saturate>;

// Rule 12: contact machine (§6.8.1.2).
using WindowSum = Unsigned<4>;
using ContactScore = Signed<10, Overflow::Saturate>;
using ContactHeight = Unsigned<9, Overflow::Saturate>;
using ContactSurface = Unsigned<13, Overflow::Saturate>;

// Rule 14: free space (§6.9).
using HistogramArea = Unsigned<15, Overflow::Saturate>;
using ValleyArea = Unsigned<14, Overflow::Saturate>;
using ValleyThreshold = Unsigned<5>;
using ValleyProduct = Unsigned<19>;

}  // namespace formats

/// Rules 7 and 8: a 9-bit pixel.
using TaggedPixel = std::uint16_t;
inline constexpr TaggedPixel no_correspondence = 0x100;

/// Rule 12: bearing[25:19] u[18:9] v[8:0].
constexpr std::uint32_t contactWord(int bearing, int u, int v) {
  return static_cast<std::uint32_t>(bearing) << 19 | static_cast<std::uint32_t>(u) << 9 |
         static_cast<std::uint32_t>(v);
}
constexpr int wordBearing(std::uint32_t contact) { return static_cast<int>(contact >> 19 & 0x7f); }
constexpr int wordColumn(std::uint32_t word) { return static_cast<int>(word >> 9 & 0x3ff); }
constexpr int wordRow(std::uint32_t word) { return static_cast<int>(word & 0x1ff); }

/// Rule 16: 13 zero bits, u[18:9], v[8:0].
constexpr std::uint32_t pointWord(std::uint32_t contact) { return contact & 0x7ffffU; }

/// Rule 14: flag[15] bearing[14:8] amplitude[7:0].
constexpr std::uint16_t peakWord(bool new_obstacle, int bearing, int amplitude) {
  return static_cast<std::uint16_t>((new_obstacle ? 0x8000 : 0) | bearing << 8 | amplitude);
}
constexpr bool peakStartsObstacle(std::uint16_t peak) { return (peak & 0x8000) != 0; }
constexpr int peakBearing(std::uint16_t peak) { return peak >> 8 & 0x7f; }
constexpr int peakAmplitude(std::uint16_t peak) { return peak & 0xff; }

}  // namespace ipm_mapping::fpga
