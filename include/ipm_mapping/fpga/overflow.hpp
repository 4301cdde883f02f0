#pragma once
// Counters of rules 1, 5, 11, 12 and 14: one a wire, in the order in which they are printed.

#include <array>
#include <cstddef>
#include <cstdint>

namespace ipm_mapping::fpga {

enum class Wire : std::uint8_t {
  Xn,  ///< saturated normalised column, reference path (rule 4)
  Yn,
  XnCurrent,  ///< the same on the current path
  YnCurrent,
  ReadWrite,  ///< reads too close to the write pointer (rule 5)
  BeamD,      ///< saturated Bresenham error (rule 11)
  BeamSlope,  ///< lines flatter than 45 degrees (rule 11)
  Bear,       ///< saturated bin of the polar histogram (rule 11)
  ContactS,   ///< saturated surface, height, score (rule 12)
  ContactH,
  ContactScore,
  A1,  ///< saturated areas (rule 14)
  A2,
  Peaks  ///< peaks past the last entry (rule 14)
};
inline constexpr std::size_t wire_count = 14;

/// Names as they stand in overflow.txt (rule 18).
inline constexpr std::array<const char*, wire_count> wire_names{
    "xn",   "yn",        "xn_current", "yn_current",    "read_write", "beam_d", "beam_slope",
    "bear", "contact_s", "contact_h",  "contact_score", "a1",         "a2",     "peaks"};

class OverflowCounters {
 public:
  using Counts = std::array<std::uint64_t, wire_count>;

  std::uint64_t& operator[](Wire wire) { return counts_[static_cast<std::size_t>(wire)]; }
  std::uint64_t operator[](Wire wire) const { return counts_[static_cast<std::size_t>(wire)]; }
  [[nodiscard]] const Counts& counts() const { return counts_; }
  void clear() { counts_.fill(0); }
  bool operator==(const OverflowCounters& other) const { return counts_ == other.counts_; }
  bool operator!=(const OverflowCounters& other) const { return counts_ != other.counts_; }

 private:
  Counts counts_{};
};

}  // namespace ipm_mapping::fpga
