// The model's figures beside the source's, with the ratio. Nothing printed in the source is used
// to derive anything.
#include <cstdio>

#include "ipm_mapping/fpga/cycles.hpp"

namespace ipm_mapping::fpga {
namespace {

constexpr int buffered_rows = 90;  // §6.3.1
constexpr int most_peaks = 25;     // §6.9.1
constexpr int source_points = 32;  // §6.10.2
const StreamShape vga{};

Cycles fillOf(const char* name) {
  for (const ModuleCycles& m : pixelPipeline(vga, 5)) {
    if (std::string(m.name) == name) return m.fill;
  }
  return -1;
}

double chain(std::initializer_list<const char*> names) {
  Cycles sum = 0;
  for (const char* name : names) sum += fillOf(name);
  return static_cast<double>(sum);
}

std::int64_t bitsOf(bool block_ram) {
  std::int64_t sum = 0;
  for (const MemoryBits& m : memoryBits(vga, 819)) {
    if (m.block_ram == block_ram) sum += m.bits;
  }
  return sum;
}

using List = std::vector<SourceComparison>;

void addModules(List& list, const FpgaClockParameters& clock) {
  const double us = 1e6 / clock.pixel_clock;
  const double homography = chain({"homography", "lens"});
  list.push_back({"homography and lens", "§6.2.2", "cycles", homography, 85, "43 + 42"});
  list.push_back({"homography and lens", "table 6.2", "µs", homography * us, 1.383,
                  "the source's 1.383 µs imply 61.45 MHz"});
  list.push_back({"frame rate", "table 6.2", "Hz",
                  clock.pixel_clock / static_cast<double>(vga.frame()), 200, ""});
  const double birds_eye = static_cast<double>(birdsEyeFill(vga, buffered_rows));
  list.push_back({"bird's-eye view", "§6.3.1", "cycles", birds_eye, 122287,
                  "slip: 90 rows of 640 are 57,600 cycles"});
  list.push_back({"bird's-eye view", "table 6.3", "ms", birds_eye * us / 1e3, 2.108,
                  "the source's figures imply 58.0 MHz"});
  list.push_back({"difference image", "table 6.4", "cycles",
                  chain({"homography", "lens", "subtraction"}), 91, "85 + 6"});
  list.push_back({"Gaussian, first block", "table 6.5", "cycles",
                  static_cast<double>(windowFill(vga)), 1282, "3 + 4 more to the result"});
  list.push_back({"thresholding", "table 6.6", "cycles", chain({"thresholding"}), 2, ""});
  list.push_back({"Otsu", "table 6.6", "cycles", static_cast<double>(otsuCycles()), 12032,
                  "off the critical path in the frame blanking"});
  list.push_back({"erosion, first block", "table 6.7", "cycles",
                  static_cast<double>(windowFill(vga)), 1282, "3 + 4 more to the result"});
  list.push_back({"localisation", "table 6.8", "cycles", chain({"localisation"}), 3646,
                  "slip: 640 + 5·640 + 6 = 3,846"});
}

void addArrays(List& list) {
  list.push_back({"free space, two peaks", "table 6.9", "cycles",
                  static_cast<double>(2 * latency::peak), 16, "without the scan of the bins"});
  list.push_back({"free space, 25 peaks", "§6.9.1", "cycles",
                  static_cast<double>(freeSpaceCycles(most_peaks)), 280, ""});
  list.push_back({"selection, one point", "§6.10.1.1", "cycles",
                  static_cast<double>(selectionCycles(1, 1)), 87,
                  "slip: table 6.10 prints 16, the figure of table 6.9"});
  list.push_back({"selection, 25 peaks", "§6.10.1.1", "cycles",
                  static_cast<double>(selectionCycles(most_peaks, most_peaks)), 2100,
                  "the source leaves out state D: 25·84"});
}

void addSystem(List& list, const FpgaClockParameters& clock) {
  FrameActivity busiest{most_peaks, most_peaks, source_points, 5};
  const FrameTiming t = frameTiming(clock, max_width, max_height, busiest);
  const double us = 1e6 / clock.pixel_clock;
  const double first = static_cast<double>(t.first_contact);
  const double birds_eye = static_cast<double>(birdsEyeFill(vga, buffered_rows));
  list.push_back({"first contact, second architecture", "§7.2.2", "cycles", first, 4610,
                  "slip: the modules' own latencies sum to 6,517"});
  list.push_back({"first contact, second architecture", "§7.2.2", "µs", first * us, 7.49,
                  "slip: 4,610 cycles are 74.7 µs"});
  list.push_back({"first contact, first architecture", "§7.2.2", "cycles", first + birds_eye,
                  126897, "122,287 + 4,610"});
  list.push_back({"first contact, first architecture", "§7.2.2", "ms",
                  (first + birds_eye) * us / 1e3, 2.05, "implies 61.9 MHz"});
  list.push_back({"frame rate", "table 7.1", "Hz", t.frame_rate, 201, "implies 61.75 MHz"});
  list.push_back({"frame rate", "§7.4.2", "Hz", t.frame_rate, 203, "implies 62.36 MHz"});
  list.push_back({"frame time", "§7.4.2", "ms", 1e3 / t.frame_rate, 4.98,
                  "implies 61.69 MHz; §8.2.3 counts the 1.8 ms of software in"});
  list.push_back({"software, 32 points", "§6.10.2", "ms", 1e3 * source_points * clock.point_time,
                  1.8, "56 µs a point, measured there"});
  list.push_back(
      {"map rate, in series", "table 7.3", "Hz", t.map_rate_in_series, 148, "4.98 ms + 32·56 µs"});
  list.push_back({"map rate, pipelined", "table 7.3", "Hz", t.map_rate_pipelined, 148,
                  "software beside the next frame's hardware"});
  list.push_back({"pixels on the beam", "§5.3", "%",
                  100.0 * line_count * max_height / (max_width * max_height), 45, "slip"});
}

void addMemory(List& list) {
  constexpr double zynq_bits = 560.0 * 1024.0 * 8.0;  // table 7.4: available block RAM
  list.push_back({"block RAM", "table 7.4", "%",
                  100.0 * static_cast<double>(bitsOf(true)) / zynq_bits, 90,
                  "819 rows of frame memory and the line buffers"});
  list.push_back({"LUTs", "table 7.4", "%", 100.0 * (3948 + 5233 + 10433 + 1630 + 349) / 53200.0,
                  41, "quoted: sum of tables 6.4, 6.6, 6.8–6.10"});
  list.push_back({"slice registers", "table 7.4", "%",
                  100.0 * (6930 + 15934 + 5642 + 723 + 386) / 106400.0, 28,
                  "quoted: sum of the same tables"});
}

std::string formatted(double value) {
  char text[32];
  const bool whole = value >= 1000.0 || value == static_cast<double>(static_cast<int>(value));
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%.3f", value);
  return text;
}

}  // namespace

std::vector<SourceComparison> compareWithSource() {
  const FpgaClockParameters clock;
  List list;
  addModules(list, clock);
  addArrays(list);
  addSystem(list, clock);
  addMemory(list);
  return list;
}

std::string comparisonTable() {
  std::string table =
      "| quantity | place | derived | source | unit | ratio | remark |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const SourceComparison& c : compareWithSource()) {
    char ratio[32];
    std::snprintf(ratio, sizeof ratio, "%.3f", c.derived / c.source);
    table += "| " + c.quantity + " | " + c.place + " | " + formatted(c.derived) + " | " +
             formatted(c.source) + " | " + c.unit + " | " + ratio + " | " + c.remark + " |\n";
  }
  return table;
}

}  // namespace ipm_mapping::fpga
