#include "ipm_mapping/fpga/radial_histogram.hpp"

#include <algorithm>

namespace ipm_mapping::fpga {
namespace {

/// Obstacle pixels of a bird's-eye view on each line of the beam (rule 11).
void polarHistogram(ImageView<const std::uint8_t> birds_eye, FocusWord focus, PolarHistogram& bear,
                    OverflowCounters& counters) {
  const int rows = beamRows(focus, birds_eye.height);
  for (int line = 0; line < line_count; ++line) {
    BeamLine beam(line, focus, counters);
    BearingCounter count;
    for (int v = 0; v < rows; ++v) {
      const int u = beam.column();
      count.add(birds_eye.contains(u, v) && birds_eye.at(u, v) == 1, counters);
      beam.step(counters);
    }
    bear[static_cast<std::size_t>(line)] = count.value();
  }
}

}  // namespace

int radiusOf(int du, int dv) {
  const int squared = du * du + dv * dv;
  int root = 0;
  for (int bit = 1 << 15; bit > 0; bit >>= 1) {  // one bit a step, as in hardware
    if ((root + bit) <= squared / (root + bit)) root += bit;
  }
  return root;
}

PeakSector peakSector(const PolarHistogram& bear, int bearing) {
  const auto inside = [&bear, bearing](int i) {
    return i >= 0 && i < line_count &&
           2 * bear[static_cast<std::size_t>(i)] >= bear[static_cast<std::size_t>(bearing)];
  };
  PeakSector sector{bearing, bearing};
  while (inside(sector.first - 1)) --sector.first;
  while (inside(sector.last + 1)) ++sector.last;
  return sector;
}

void FirstArchitecture::countLine(ImageView<const std::uint8_t> birds_eye, FocusWord focus,
                                  int line) {
  OverflowCounters ignored;  // the polar histogram has counted this line's saturations
  BeamLine beam(line, focus, ignored);
  const int rows = beamRows(focus, birds_eye.height);
  for (int v = 0; v < rows; ++v) {
    const int u = beam.column();
    beam.step(ignored);
    if (!birds_eye.contains(u, v) || birds_eye.at(u, v) == birds_eye_unseen) continue;
    const int radius = radiusOf(u - focus.u, v - focus.v);
    if (radius >= static_cast<int>(radii)) continue;
    Bin& bin = bins_[static_cast<std::size_t>(radius)];
    bin.obstacle += birds_eye.at(u, v);
    ++bin.seen;
  }
}

int FirstArchitecture::firstRadius() const {
  constexpr int whole = formats::RadialThreshold::highest() + 1;
  for (std::size_t radius = 0; radius < radii; ++radius) {
    const Bin& bin = bins_[radius];
    if (bin.obstacle > 0 && bin.obstacle * whole >= bin.seen * threshold_) {
      return static_cast<int>(radius);
    }
  }
  return -1;
}

void FirstArchitecture::run(ImageView<const std::uint8_t> birds_eye, FocusWord focus,
                            const FrameParameters& p, FirstArchitectureResults& results) {
  results.overflow.clear();
  polarHistogram(birds_eye, focus, results.bear, results.overflow);
  freeSpace(results.bear, p, results.peaks, results.overflow);
  results.radius.fill(-1);
  for (int peak = 0; peak < results.peaks.size; ++peak) {
    bins_.fill({});
    const PeakSector sector = peakSector(results.bear, peakBearing(results.peaks[peak]));
    for (int line = sector.first; line <= sector.last; ++line) countLine(birds_eye, focus, line);
    results.radius[static_cast<std::size_t>(peak)] = firstRadius();
  }
}

}  // namespace ipm_mapping::fpga
