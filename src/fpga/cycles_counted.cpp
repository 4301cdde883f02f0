// Clocked machines behind the formulas of cycles.hpp.
#include <algorithm>
#include <vector>

#include "ipm_mapping/fpga/cycles.hpp"

namespace ipm_mapping::fpga::counted {
namespace {

/// A shift register of valid bits.
class DelayLine {
 public:
  explicit DelayLine(Cycles depth) : bits_(static_cast<std::size_t>(depth), 0) {}
  bool clock(bool in) {
    if (bits_.empty()) return in;
    const bool out = bits_[at_] != 0;
    bits_[at_] = in;
    at_ = (at_ + 1) % bits_.size();
    return out;
  }

 private:
  std::vector<char> bits_;
  std::size_t at_ = 0;
};

/// A raster of valid bits with its blanking.
class Raster {
 public:
  explicit Raster(const StreamShape& s) : shape_(s) {}
  bool clock() {
    const bool valid = row_ < shape_.height && column_ < shape_.width;
    if (++column_ == shape_.row()) {
      column_ = 0;
      ++row_;
    }
    return valid;
  }

 private:
  StreamShape shape_;
  Cycles column_ = 0;
  int row_ = 0;
};

/// Line buffers of a 3x3 stage: a block leaves with every pixel once two rows and two pixels are
/// stored. Blocks across the row's ends are formed too; rule 8 marks their results.
class WindowBuffer {
 public:
  explicit WindowBuffer(const StreamShape& s) : needed_(2 * Cycles{s.width} + 2) {}
  bool clock(bool pixel) {
    if (!pixel) return false;
    return stored_++ >= needed_;
  }

 private:
  Cycles needed_, stored_ = 0;
};

/// Watches a stream of valid bits.
class Probe {
 public:
  void clock(bool valid, Cycles now) {
    if (!valid) return;
    if (seen_ == 0) times_.first = now;
    times_.last = now;
    ++seen_;
  }
  [[nodiscard]] const FillAndLast& times() const { return times_; }

 private:
  FillAndLast times_;
  Cycles seen_ = 0;
};

/// Runs `machine` on a raster until it has been silent for as long as any pipe is deep.
template <class Machine>
FillAndLast runRaster(const StreamShape& s, Machine&& machine) {
  Raster raster(s);
  Probe probe;
  const Cycles end = s.frame() + 4 * s.row() + 1000;
  for (Cycles now = 0; now < end; ++now) probe.clock(machine(raster.clock()), now);
  return probe.times();
}

}  // namespace

FillAndLast window(const StreamShape& s) {
  WindowBuffer buffer(s);
  DelayLine block(latency::block), convolution(latency::convolution);
  return runRaster(s,
                   [&](bool pixel) { return convolution.clock(block.clock(buffer.clock(pixel))); });
}

FillAndLast pipelineToErosion(const StreamShape& s) {
  DelayLine homography(latency::homography_divider + latency::homography_rest);
  DelayLine lens(latency::lens_divider + latency::lens_rest);
  DelayLine subtraction(latency::subtraction), thresholding(latency::thresholding);
  WindowBuffer gaussian_rows(s), erosion_rows(s);
  DelayLine gaussian(latency::block + latency::convolution);
  DelayLine erosion(latency::block + latency::convolution);
  return runRaster(s, [&](bool pixel) {
    const bool difference = subtraction.clock(lens.clock(homography.clock(pixel)));
    const bool mask = thresholding.clock(gaussian.clock(gaussian_rows.clock(difference)));
    return erosion.clock(erosion_rows.clock(mask));
  });
}

Cycles firstContact(const StreamShape& s, int min_height) {
  Cycles column = 0, rows = 0, now = 0;
  // A row is scanned from its line buffer while the next one arrives; the contact is judged when
  // the row after the triangle's last one is complete.
  while (rows < 1 + min_height) {
    ++now;
    if (++column == s.row()) {
      column = 0;
      ++rows;
    }
  }
  return now + latency::contact_output;
}

Cycles otsu() {
  Cycles now = 0;
  for (int grey = 0; grey < 256; ++grey) {
    for (Cycles step = 0; step < latency::otsu_rest; ++step) ++now;
    for (Cycles step = 0; step < latency::otsu_divider; ++step) ++now;
  }
  return now;
}

Cycles freeSpace(const PolarHistogram& bear, const FrameParameters& p) {
  Peaks peaks;
  OverflowCounters counters;
  fpga::freeSpace(bear, p, peaks, counters);
  Cycles now = 0;
  int next = 0;
  for (int bearing = 0; bearing < line_count; ++bearing) {
    ++now;
    if (next < peaks.size && peakBearing(peaks[next]) == bearing) {
      now += latency::peak;
      ++next;
    }
  }
  return now;
}

Cycles selection(const Contacts& cor, const Peaks& peaks, int bearing_tolerance) {
  SelectedContacts selected;
  selectContacts(cor, peaks, bearing_tolerance, selected);
  Cycles now = 0;
  for (int peak = 0; peak < peaks.size; ++peak) {
    now += latency::peak_match;
    for (std::size_t i = 0; i < cor.size(); ++i) ++now;
  }
  for (int i = 0; i < selected.size; ++i) now += latency::point_output;
  return now;
}

Cycles fifoOccupancy(const StreamShape& s) {
  const Cycles start = Cycles{s.height - 1} * s.line_blanking;  // no read ever finds it empty
  const Cycles pixels = Cycles{s.width} * s.height;
  Raster raster(s);
  Cycles written = 0, read = 0, highest = 0;
  for (Cycles now = 0; read < pixels; ++now) {
    written += raster.clock();
    if (now >= start) ++read;
    if (read > written) return -1;
    highest = std::max(highest, written - read);
  }
  return highest;
}

}  // namespace ipm_mapping::fpga::counted
