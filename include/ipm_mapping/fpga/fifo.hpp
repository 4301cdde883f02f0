#pragma once
// The FIFO between fabric and processor (the source, §6.10.2; rule 16): one little-endian u32 a
// selected point, to and from any file or device.

#include <cstdint>
#include <istream>
#include <optional>
#include <ostream>

#include "ipm_mapping/fpga/selection.hpp"

namespace ipm_mapping::fpga {

/// A point of the current image as the FIFO carries it.
struct FifoPoint {
  int u = 0;
  int v = 0;
  bool operator==(const FifoPoint& o) const { return u == o.u && v == o.v; }
};

/// Appends a frame's points in bearing order. False when the stream fails.
bool writeFifo(std::ostream& out, const SelectedContacts& selected);

/// Reads points one by one. Bearing and time are not in the words: who reads knows how many
/// points a frame has, or takes a stream of its own per frame.
class FifoReader {
 public:
  explicit FifoReader(std::istream& in) : in_(in) {}

  /// The next point; nothing at the end, or where the last word is cut off.
  [[nodiscard]] std::optional<FifoPoint> next();
  /// Words dropped because one of the 13 upper bits was set.
  [[nodiscard]] std::uint64_t malformed() const { return malformed_; }
  /// Whether the stream ended within a word.
  [[nodiscard]] bool truncated() const { return truncated_; }

 private:
  std::optional<std::uint32_t> word();

  std::istream& in_;
  std::uint64_t malformed_ = 0;
  bool truncated_ = false;
};

}  // namespace ipm_mapping::fpga
