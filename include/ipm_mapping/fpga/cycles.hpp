#pragma once
// Cycle and memory model of the datapath: closed formulas, and machines that are stepped clock by
// clock to check them. The source's figures are never inputs here (docs/fpga.md compares them).

#include <cstdint>
#include <string>
#include <vector>

#include "ipm_mapping/fpga/datapath.hpp"
#include "ipm_mapping/parameters/fpga_parameters.hpp"

namespace ipm_mapping::fpga {

using Cycles = std::int64_t;

namespace latency {
// Pipeline depths, in cycles; §6.2 to §6.10 draw the registers.
inline constexpr Cycles lens_divider = 34, lens_rest = 9;              // §6.2.2
inline constexpr Cycles homography_divider = 36, homography_rest = 6;  // §6.2.2
inline constexpr Cycles subtraction = 6;                               // §6.4.1
inline constexpr Cycles block = 3, convolution = 4;                    // §6.5.2, §6.7
inline constexpr Cycles thresholding = 2;                              // §6.6.2
inline constexpr Cycles otsu_divider = 39, otsu_rest = 8;              // §6.6.1
inline constexpr Cycles contact_output = 6;                            // §6.8.2
inline constexpr Cycles peak = 8;                                      // §6.9.1: states IDLE, A, B
inline constexpr Cycles peak_match = 4;    // §6.10.1: states IDLE, A, C
inline constexpr Cycles point_output = 3;  // §6.10.1: state D
}  // namespace latency

/// Size and pauses of the pixel stream.
struct StreamShape {
  int width = max_width, height = max_height;
  int line_blanking = 0;   ///< cycles after a row
  int frame_blanking = 0;  ///< cycles after the frame

  [[nodiscard]] Cycles row() const { return width + line_blanking; }
  [[nodiscard]] Cycles frame() const { return row() * height + frame_blanking; }
};

/// A module of the pixel pipeline.
struct ModuleCycles {
  const char* name;
  Cycles fill;      ///< from a pixel in to the first result out
  Cycles interval;  ///< cycles between two inputs that it can take
  Cycles stalls;    ///< cycles of a frame in which the blanking leaves it without input
};

/// What a frame's content decides.
struct FrameActivity {
  int peaks = 0;
  int obstacles = 0;
  int points = 0;
  int min_height = 5;  ///< rows of the smallest triangle
};
[[nodiscard]] FrameActivity activityOf(const Results& results, int min_height);

/// Formulas.
[[nodiscard]] Cycles windowFill(const StreamShape& s);  ///< two rows and two pixels
[[nodiscard]] Cycles localizationFill(const StreamShape& s, int min_height);
[[nodiscard]] Cycles otsuCycles();
[[nodiscard]] Cycles freeSpaceCycles(int peaks);
[[nodiscard]] Cycles selectionCycles(int peaks, int points);
[[nodiscard]] std::vector<ModuleCycles> pixelPipeline(const StreamShape& s, int min_height);
/// Entries of the FIFO that lets the datapath run through the line blanking (eq. 6.6).
[[nodiscard]] Cycles fifoDepth(const StreamShape& s);
/// Rows that a camera pitched down has to buffer before the bird's-eye view can start, as cycles.
[[nodiscard]] Cycles birdsEyeFill(const StreamShape& s, int buffered_rows);

struct FrameTiming {
  Cycles first_contact;       ///< from the first pixel to the first possible contact
  Cycles after_last_pixel;    ///< from the last pixel to the last selected point
  bool otsu_hidden;           ///< the next frame's threshold is ready before its first pixel
  double frame_rate;          ///< Hz, hardware alone
  double to_map;              ///< s, from the first pixel to the last point in the map
  double map_rate_in_series;  ///< Hz, software after hardware
  double map_rate_pipelined;  ///< Hz, software of one frame beside the hardware of the next
};
[[nodiscard]] FrameTiming frameTiming(const FpgaClockParameters& clock, int width, int height,
                                      const FrameActivity& activity);

/// Bits of storage of one module.
struct MemoryBits {
  const char* name;
  std::int64_t bits;
  bool block_ram;  ///< false: slice registers
};
[[nodiscard]] std::vector<MemoryBits> memoryBits(const StreamShape& s, int memory_rows);

/// Machines stepped clock by clock: what the formulas are checked against.
namespace counted {
struct FillAndLast {
  Cycles first = 0;  ///< cycle of the first output, counted from the first pixel in
  Cycles last = 0;
};
/// A 3x3 stage fed with a raster.
[[nodiscard]] FillAndLast window(const StreamShape& s);
/// The whole chain from coordinates generator to erosion.
[[nodiscard]] FillAndLast pipelineToErosion(const StreamShape& s);
/// Localisation: cycle of the first possible contact of a triangle that starts in the first row.
[[nodiscard]] Cycles firstContact(const StreamShape& s, int min_height);
[[nodiscard]] Cycles otsu();
[[nodiscard]] Cycles freeSpace(const PolarHistogram& bear, const FrameParameters& p);
[[nodiscard]] Cycles selection(const Contacts& cor, const Peaks& peaks, int bearing_tolerance);
/// Highest fill of a FIFO written with blanking and read without, once reading may start.
[[nodiscard]] Cycles fifoOccupancy(const StreamShape& s);
}  // namespace counted

/// One line of the comparison with the source.
struct SourceComparison {
  std::string quantity, place, unit;
  double derived, source;
  std::string remark;
};
[[nodiscard]] std::vector<SourceComparison> compareWithSource();
/// The same as a Markdown table.
[[nodiscard]] std::string comparisonTable();

}  // namespace ipm_mapping::fpga
