#include "ipm_mapping/fpga/free_space.hpp"

#include <algorithm>

namespace ipm_mapping::fpga {
namespace {

int at(const PolarHistogram& bear, int bearing) {
  const bool inside = bearing >= 0 && bearing < line_count;
  return inside ? bear[static_cast<std::size_t>(bearing)] : 0;
}

/// Last bearing of the run of equal values that starts here.
int runEnd(const PolarHistogram& bear, int first) {
  int last = first;
  while (last + 1 < line_count && at(bear, last + 1) == at(bear, first)) ++last;
  return last;
}

bool isPeak(const PolarHistogram& bear, int first, int last, bool single_bin) {
  const int value = at(bear, first);
  return value > at(bear, first - 1) && value > at(bear, last + 1) &&
         (!single_bin || first == last);
}

struct HalfValley {
  Integer under = 0;
  Integer below = 0;
};

/// Sums over first ... last, inclusive; negative differences count 0.
HalfValley halfValley(const PolarHistogram& bear, int peak, int first, int last) {
  HalfValley half;
  for (int j = first; j <= last; ++j) {
    half.under += at(bear, j);
    half.below += std::max(0, at(bear, peak) - at(bear, j));
  }
  return half;
}

void pushPeak(const PolarHistogram& bear, int bearing, const FrameParameters& p, Peaks& peaks,
              OverflowCounters& counters) {
  if (peaks.full()) {
    ++counters[Wire::Peaks];
    return;
  }
  bool starts = true;
  if (peaks.size > 0) {
    const int before = peakBearing(peaks[peaks.size - 1]);
    starts = separate(valleyBetween(bear, before, bearing, counters), p);
  }
  peaks.push(peakWord(starts, bearing, at(bear, bearing)));
}

}  // namespace

Valley valleyBetween(const PolarHistogram& bear, int i1, int i2, OverflowCounters& counters) {
  const int step = (i2 - i1) / 2;
  const HalfValley left = halfValley(bear, i1, i1, i1 + step);
  const HalfValley right = halfValley(bear, i2, i2 - step, i2);
  using Sum = Unsigned<16>;
  return {
      saturate<formats::HistogramArea>(Sum::fromRaw(left.under + right.under), counters[Wire::A1]),
      saturate<formats::ValleyArea>(Sum::fromRaw(left.below + right.below), counters[Wire::A2])};
}

bool separate(const Valley& valley, const FrameParameters& p) {
  const auto threshold = formats::ValleyThreshold::fromRaw(p.valley_threshold);
  const auto scaled = widen<formats::ValleyProduct>(valley.below * threshold);
  return p.free_space_rule == 0 ? scaled.raw() > valley.under.raw()
                                : valley.under.raw() > scaled.raw();
}

void freeSpace(const PolarHistogram& bear, const FrameParameters& p, Peaks& peaks,
               OverflowCounters& counters) {
  peaks.clear();
  for (int first = 0; first < line_count;) {
    const int last = runEnd(bear, first);
    if (isPeak(bear, first, last, p.single_bin_peaks != 0)) {
      pushPeak(bear, (first + last) / 2, p, peaks, counters);
    }
    first = last + 1;
  }
}

}  // namespace ipm_mapping::fpga
