#include <gtest/gtest.h>

#include "fpga/support.hpp"
#include "ipm_mapping/fpga/contact_points.hpp"

namespace ipm_mapping::fpga {
namespace {

std::vector<int> columnsOf(int line, FocusWord focus, int rows, OverflowCounters& counters) {
  BeamLine beam(line, focus, counters);
  std::vector<int> columns;
  for (int v = 0; v < rows; ++v) {
    columns.push_back(beam.column());
    beam.step(counters);
  }
  return columns;
}

TEST(BeamTwin, EveryLineStaysWithinOnePixelOfTheStraightLineToTheFocus) {
  OverflowCounters counters;
  for (const FocusWord focus : {FocusWord{320, 1400}, FocusWord{-700, 2100}, FocusWord{5000, 6000},
                                FocusWord{100, 700}, FocusWord{8191, 8191}}) {
    for (int line = 0; line < line_count; ++line) {
      const double slope = static_cast<double>(focus.u - startColumn(line)) / focus.v;
      const auto columns = columnsOf(line, focus, 480, counters);
      if (std::abs(slope) > 1.0) continue;
      for (int v = 0; v < 480; ++v) {
        ASSERT_NEAR(columns[static_cast<std::size_t>(v)], startColumn(line) + slope * v, 1.0)
            << line << ' ' << v;
      }
    }
  }
}

TEST(BeamTwin, AFocusBehindLetsTheLinesDiverge) {
  OverflowCounters counters;
  EXPECT_LT(columnsOf(0, {320, -900}, 200, counters).back(), startColumn(0));
  EXPECT_GT(columnsOf(79, {320, -900}, 200, counters).back(), startColumn(79));
  EXPECT_GT(columnsOf(0, {320, 900}, 200, counters).back(), startColumn(0));
}

TEST(BeamTwin, TestsAPixelBeforeItSteps) {
  OverflowCounters counters;
  EXPECT_EQ(columnsOf(10, {8000, 9000 / 2}, 1, counters).front(), startColumn(10));
}

TEST(BeamTwin, FlatLinesRunAtFortyFiveDegreesAndAreCountedOnce) {
  OverflowCounters counters;
  const auto columns = columnsOf(0, {8191, 1}, 50, counters);
  EXPECT_EQ(columns.back(), startColumn(0) + 49);
  EXPECT_EQ(counters[Wire::BeamSlope], 1U);
}

TEST(BeamTwin, ErrorRegisterSaturatesAndCountsEveryWrite) {
  OverflowCounters counters;
  // D starts at 2 du - 1 and grows by 2 du - 2 a row: du = 8187.
  columnsOf(0, {8191, 1}, 100, counters);
  const Integer du = 8191 - 4, limit = 262143;
  std::uint64_t expected = 0;
  Integer d = 2 * du - 1;
  for (int write = 0; write < 100; ++write) {
    d += 2 * du - 2;
    if (d > limit) ++expected, d = limit;
  }
  EXPECT_GT(expected, 80U);
  EXPECT_EQ(counters[Wire::BeamD], expected);
}

TEST(BeamTwin, EndsInTheRowOfAFocusInsideTheImage) {
  EXPECT_EQ(beamRows({0, 100}, 480), 101);
  EXPECT_EQ(beamRows({0, 479}, 480), 480);
  EXPECT_EQ(beamRows({0, 480}, 480), 480);
  EXPECT_EQ(beamRows({0, -5}, 480), 480);
  EXPECT_EQ(beamRows({0, 1}, 480), 2);
}

TEST(BeamTwin, BinSaturatesAt255AndCountsWhatItLoses) {
  Image<std::uint8_t> eroded(640, 480, 1);
  FrameParameters p = test::driveParameters(640, 480);
  p.focus_u = startColumn(40);
  p.focus_v = 8191;
  PolarHistogram bear{};
  Contacts cor{};
  OverflowCounters counters;
  localize(std::as_const(eroded).view(), p, bear, cor, counters);
  EXPECT_EQ(bear[40], 255);
  EXPECT_EQ(counters[Wire::Bear], 80U * (480 - 255));
}

/// Feeds window sums of consecutive rows (0 is a background pixel) and closes the line.
ContactEntry runMachine(const std::vector<int>& sums, const FrameParameters& p) {
  OverflowCounters counters;
  ContactMachine machine(3, p);
  int v = 0;
  for (const int a : sums) {
    machine.row(a > 0, 100 + v, v, a, counters);
    ++v;
  }
  machine.finish();
  return machine.contact();
}

TEST(ContactMachineTwin, FindsTheLowestRowOfANarrowingTriangle) {
  const FrameParameters p = test::driveParameters(640, 480);
  const ContactEntry contact = runMachine({11, 11, 9, 9, 7, 5, 3, 0}, p);
  ASSERT_TRUE(contact.found);
  EXPECT_EQ(contact.word, contactWord(3, 106, 6));
}

TEST(ContactMachineTwin, NeedsScoreHeightAndWidthBeyondTheirLimits) {
  FrameParameters p = test::driveParameters(640, 480);
  EXPECT_FALSE(runMachine({9, 9, 9, 9, 0}, p).found);    // h = 4 < 5
  EXPECT_TRUE(runMachine({9, 9, 9, 9, 9, 0}, p).found);  // h = 5, Sc = 5 > 4
  p.score_min = 5;
  EXPECT_FALSE(runMachine({9, 9, 9, 9, 9, 0}, p).found);
  p.score_min = 4;
  EXPECT_FALSE(runMachine({4, 4, 4, 4, 4, 0}, p).found);  // S = 4h is not enough
  EXPECT_TRUE(runMachine({5, 4, 4, 4, 4, 0}, p).found);
}

TEST(ContactMachineTwin, MethodsDifferWhereTheShapeWidensAgain) {
  FrameParameters p = test::driveParameters(640, 480);
  const std::vector<int> dented{9, 8, 7, 6, 6, 9, 9, 8, 0};  // widens once, after five rows
  p.method = 1;
  const ContactEntry triangle = runMachine(dented, p);
  ASSERT_TRUE(triangle.found);
  EXPECT_EQ(wordRow(triangle.word), 7);
  p.method = 0;
  EXPECT_FALSE(runMachine(dented, p).found);  // two rows since the score was cleared
}

TEST(ContactMachineTwin, ATriangleOpenAtTheLinesEndIsJudged) {
  EXPECT_TRUE(runMachine({9, 9, 8, 8, 7}, test::driveParameters(640, 480)).found);
}

TEST(ContactMachineTwin, TheLastTriangleOfALineWins) {
  const FrameParameters p = test::driveParameters(640, 480);
  const ContactEntry contact = runMachine({9, 9, 9, 9, 9, 0, 8, 8, 8, 8, 8, 0, 7, 0}, p);
  EXPECT_EQ(wordRow(contact.word), 10);
}

TEST(ContactMachineTwin, WindowReadsZeroOutsideTheImage) {
  const Image<std::uint8_t> ones(20, 4, 1);
  EXPECT_EQ(windowSum(ones.view(), 10, 1), 11);
  EXPECT_EQ(windowSum(ones.view(), 0, 1), 6);
  EXPECT_EQ(windowSum(ones.view(), -3, 1), 3);
  EXPECT_EQ(windowSum(ones.view(), 25, 1), 0);
}

}  // namespace
}  // namespace ipm_mapping::fpga
