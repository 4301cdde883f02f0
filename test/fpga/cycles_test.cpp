#include "ipm_mapping/fpga/cycles.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "fpga/support.hpp"

namespace ipm_mapping::fpga {
namespace {

std::vector<StreamShape> shapes() {
  return {{640, 480, 0, 0}, {640, 480, 94, 30000}, {64, 48, 0, 0}, {64, 48, 7, 500}, {33, 9, 1, 0}};
}

Cycles sumOfFills(const StreamShape& s, std::size_t modules) {
  const auto pipeline = pixelPipeline(s, 5);
  Cycles sum = 0;
  for (std::size_t i = 0; i < modules; ++i) sum += pipeline[i].fill;
  return sum;
}

TEST(Cycles, CountedWindowFillEqualsItsFormula) {
  for (const StreamShape& s : shapes()) {
    const auto times = counted::window(s);
    EXPECT_EQ(times.first, windowFill(s) + latency::block + latency::convolution);
    EXPECT_EQ(times.last, s.frame() - s.frame_blanking - s.line_blanking - 1 + latency::block +
                              latency::convolution);
  }
}

TEST(Cycles, CountedChainToErosionIsTheSumOfTheModulesWithoutBlanking) {
  const StreamShape vga;
  EXPECT_EQ(counted::pipelineToErosion(vga).first, sumOfFills(vga, 6));
  const StreamShape small{64, 48, 0, 0};
  EXPECT_EQ(counted::pipelineToErosion(small).first, sumOfFills(small, 6));
}

TEST(Cycles, BlankingThatFallsIntoAFillCanOnlyDelayIt) {
  // Two pixels into the third row in one stage, four in two: the second stage may wait for less
  // blanking than its own formula counts, never for more.
  for (const StreamShape& s : shapes()) {
    const Cycles counted = counted::pipelineToErosion(s).first;
    EXPECT_LE(counted, sumOfFills(s, 6));
    EXPECT_GE(counted, sumOfFills({s.width, s.height, 0, 0}, 6));
  }
}

TEST(Cycles, CountedLocalizationEqualsItsFormula) {
  for (const StreamShape& s : shapes()) {
    for (const int height : {0, 1, 5, 9}) {
      EXPECT_EQ(counted::firstContact(s, height), localizationFill(s, height));
    }
  }
}

TEST(Cycles, CountedArraysEqualTheirFormulasOnRealFrames) {
  test::Generator random(31);
  Wires wires;
  int most = 0;
  for (int round = 0; round < 60; ++round) {
    const OwnedInputs owned = test::randomInputs(320, 240, random);
    runAllWires(owned.inputs(), wires);
    const Results& r = wires.results;
    most = std::max(most, r.peaks.size);
    EXPECT_EQ(counted::freeSpace(r.bear, owned.parameters), freeSpaceCycles(r.peaks.size));
    EXPECT_EQ(
        counted::selection(r.cor, r.peaks, static_cast<int>(owned.parameters.bearing_tolerance)),
        selectionCycles(r.peaks.size, r.selected.size));
  }
  EXPECT_GT(most, 5);
  EXPECT_EQ(counted::otsu(), otsuCycles());
}

TEST(Cycles, FifoNeverRunsEmptyAndStaysBelowEquation66) {
  for (const StreamShape& s : shapes()) {
    const Cycles occupancy = counted::fifoOccupancy(s);
    EXPECT_GE(occupancy, 0);
    EXPECT_LE(occupancy, fifoDepth(s));
    EXPECT_GE(2 * occupancy, fifoDepth(s));
  }
}

TEST(Cycles, SourcesOwnLatenciesSumTo6517) { EXPECT_EQ(sumOfFills(StreamShape{}, 7), 6517); }

TEST(Cycles, BlankingLowersTheFrameRateAndHidesOtsu) {
  FpgaClockParameters clock;
  const FrameActivity activity{10, 5, 5, 5};
  const FrameTiming without = frameTiming(clock, 640, 480, activity);
  EXPECT_NEAR(without.frame_rate, 203.0, 0.05);
  EXPECT_FALSE(without.otsu_hidden);
  clock.line_blanking = 94;
  clock.frame_blanking = static_cast<int>(otsuCycles());
  const FrameTiming with = frameTiming(clock, 640, 480, activity);
  EXPECT_TRUE(with.otsu_hidden);
  EXPECT_LT(with.frame_rate, without.frame_rate);
  EXPECT_NEAR(1.0 / with.frame_rate, (734.0 * 480 + 12032) / 62.36e6, 1e-9);
  EXPECT_GT(with.map_rate_pipelined, with.map_rate_in_series);
}

TEST(Cycles, MemoryHoldsWhatTheArraysNeed) {
  std::int64_t frame = 0, arrays = 0;
  for (const MemoryBits& m : memoryBits(StreamShape{}, 819)) {
    if (std::string(m.name) == "reference frame") frame = m.bits;
    if (std::string(m.name) == "Cor" || std::string(m.name) == "Peaks") arrays += m.bits;
  }
  EXPECT_EQ(frame, 2457600);
  EXPECT_EQ(arrays, 80 * 26 + 32 * 16);
}

TEST(Cycles, TheDocumentationShowsTheModelsTable) {
  std::ifstream in(std::string(SOURCE_DIRECTORY) + "/docs/fpga.md");
  std::ostringstream page;
  page << in.rdbuf();
  EXPECT_NE(page.str().find(comparisonTable()), std::string::npos) << "docs/fpga.md should hold:\n"
                                                                   << comparisonTable();
}

}  // namespace
}  // namespace ipm_mapping::fpga
