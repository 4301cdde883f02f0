#pragma once
// Twin of the polar histogram: a beam of Bresenham lines from the first row to the focus
// (the source, §6.8.1; rule 11).

#include <array>
#include <cstdint>

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/fpga/frame_parameters.hpp"
#include "ipm_mapping/fpga/overflow.hpp"

namespace ipm_mapping::fpga {

using PolarHistogram = std::array<std::uint8_t, line_count>;

/// The focus word: v in the upper, u in the lower 14 bits.
struct FocusWord {
  int u = 0;
  int v = 0;
};

/// Rows of the beam: up to the focus where it lies inside the image.
[[nodiscard]] int beamRows(FocusWord focus, int height);

/// Starting column of line i.
constexpr int startColumn(int line) { return line_spacing * line + line_spacing / 2; }

/// One line's Bresenham registers.
class BeamLine {
 public:
  /// Counts the start value of D and the slope of the line.
  BeamLine(int line, FocusWord focus, OverflowCounters& counters);

  [[nodiscard]] int column() const { return u_; }
  /// The update after a tested row (state B of §6.8.1).
  void step(OverflowCounters& counters);

 private:
  formats::BeamDelta du_, dv_;
  int direction_;
  int u_;
  formats::BeamError error_;
};

/// Obstacle pixels of one line, saturating at 255.
class BearingCounter {
 public:
  void add(bool pixel, OverflowCounters& counters);
  [[nodiscard]] std::uint8_t value() const { return static_cast<std::uint8_t>(count_.raw()); }

 private:
  formats::BearingCount count_;
};

/// A pixel of the eroded image; 0 outside.
inline bool obstacleAt(ImageView<const std::uint8_t> eroded, int u, int v) {
  return eroded.contains(u, v) && eroded.at(u, v) != 0;
}

}  // namespace ipm_mapping::fpga
