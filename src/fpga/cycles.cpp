#include "ipm_mapping/fpga/cycles.hpp"

#include <algorithm>

namespace ipm_mapping::fpga {
namespace {

constexpr Cycles lens_latency = latency::lens_divider + latency::lens_rest;
constexpr Cycles homography_latency = latency::homography_divider + latency::homography_rest;
constexpr Cycles window_latency = latency::block + latency::convolution;

}  // namespace

FrameActivity activityOf(const Results& results, int min_height) {
  FrameActivity activity;
  activity.peaks = results.peaks.size;
  activity.points = results.selected.size;
  activity.min_height = min_height;
  for (const std::uint16_t peak : results.peaks) activity.obstacles += peakStartsObstacle(peak);
  return activity;
}

Cycles windowFill(const StreamShape& s) { return 2 * s.row() + 2; }

Cycles localizationFill(const StreamShape& s, int min_height) {
  return s.row() * (1 + min_height) + latency::contact_output;
}

Cycles otsuCycles() { return 256 * (latency::otsu_divider + latency::otsu_rest); }

Cycles freeSpaceCycles(int peaks) { return line_count + peaks * latency::peak; }

Cycles selectionCycles(int peaks, int points) {
  return peaks * (line_count + latency::peak_match) + points * latency::point_output;
}

std::vector<ModuleCycles> pixelPipeline(const StreamShape& s, int min_height) {
  const Cycles stalls = s.frame() - Cycles{s.width} * s.height;
  return {{"homography", homography_latency, 1, stalls},
          {"lens", lens_latency, 1, stalls},
          {"subtraction", latency::subtraction, 1, stalls},
          {"gaussian", windowFill(s) + window_latency, 1, stalls},
          {"thresholding", latency::thresholding, 1, stalls},
          {"erosion", windowFill(s) + window_latency, 1, stalls},
          {"localisation", localizationFill(s, min_height), 1, stalls}};
}

Cycles fifoDepth(const StreamShape& s) { return Cycles{s.height} * s.line_blanking; }

Cycles birdsEyeFill(const StreamShape& s, int buffered_rows) {
  return buffered_rows * s.row() + homography_latency;
}

FrameTiming frameTiming(const FpgaClockParameters& clock, int width, int height,
                        const FrameActivity& activity) {
  const StreamShape s{width, height, clock.line_blanking, clock.frame_blanking};
  FrameTiming t{};
  for (const ModuleCycles& module : pixelPipeline(s, activity.min_height)) {
    t.first_contact += module.fill;
  }
  // The triangle's rows are part of the frame; what follows the last pixel is the pipe alone.
  const Cycles pipe = t.first_contact - activity.min_height * s.row();
  t.after_last_pixel =
      pipe + freeSpaceCycles(activity.peaks) + selectionCycles(activity.peaks, activity.points);
  t.otsu_hidden = otsuCycles() <= clock.frame_blanking;
  const double frame = static_cast<double>(s.frame()) / clock.pixel_clock;
  const double drain = static_cast<double>(t.after_last_pixel) / clock.pixel_clock;
  const double software = activity.points * clock.point_time;
  t.frame_rate = 1.0 / frame;
  t.to_map = frame + drain + software;
  t.map_rate_in_series = 1.0 / (frame + software);
  t.map_rate_pipelined = 1.0 / std::max(frame, software + clock.matrix_time);
  return t;
}

std::vector<MemoryBits> memoryBits(const StreamShape& s, int memory_rows) {
  const std::int64_t w = s.width;
  return {{"reference frame", w * s.height * 8, true},
          {"rows of the next frame", w * std::max(memory_rows - s.height, 0) * 8, true},
          {"pixel FIFO", fifoDepth(s) * 8, true},
          {"Gaussian line buffers", 3 * w * 9, true},
          {"erosion line buffers", 3 * w, true},
          {"localisation line buffers", 2 * w, false},
          {"grey histogram", 256 * formats::BinCount::width, false},
          {"Bear", line_count * formats::BearingCount::width, false},
          {"Cor", line_count * 26, false},
          {"Peaks", max_peaks * 16, false}};
}

}  // namespace ipm_mapping::fpga
