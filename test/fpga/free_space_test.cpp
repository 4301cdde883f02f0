#include "ipm_mapping/fpga/free_space.hpp"

#include <gtest/gtest.h>

#include "fpga/support.hpp"
#include "ipm_mapping/fpga/selection.hpp"

namespace ipm_mapping::fpga {
namespace {

PolarHistogram bear(std::initializer_list<std::pair<int, int>> entries) {
  PolarHistogram bins{};
  for (const auto& [bearing, value] : entries) {
    bins[static_cast<std::size_t>(bearing)] = static_cast<std::uint8_t>(value);
  }
  return bins;
}

struct Found {
  Peaks peaks;
  OverflowCounters counters;
};

Found find(const PolarHistogram& bins, FrameParameters p = test::driveParameters(640, 480)) {
  Found found;
  freeSpace(bins, p, found.peaks, found.counters);
  return found;
}

std::vector<int> bearings(const Peaks& peaks) {
  std::vector<int> all;
  for (const std::uint16_t peak : peaks) all.push_back(peakBearing(peak));
  return all;
}

TEST(FreeSpaceTwin, PeaksAreRunsHigherThanBothNeighboursAlsoAtTheEdges) {
  const PolarHistogram bins =
      bear({{0, 5}, {1, 3}, {10, 4}, {11, 4}, {12, 4}, {13, 4}, {14, 2}, {15, 2}, {79, 1}});
  EXPECT_EQ(bearings(find(bins).peaks), (std::vector<int>{0, 11, 79}));
  FrameParameters single = test::driveParameters(640, 480);
  single.single_bin_peaks = 1;
  EXPECT_EQ(bearings(find(bins, single).peaks), (std::vector<int>{0, 79}));
}

TEST(FreeSpaceTwin, AFlatHistogramIsOneBroadPeakAndAnEmptyOneNone) {
  PolarHistogram flat{};
  EXPECT_EQ(find(flat).peaks.size, 0);
  flat.fill(9);
  EXPECT_EQ(bearings(find(flat).peaks), (std::vector<int>{39}));
}

TEST(FreeSpaceTwin, FirstPeakStartsAnObstacleAndWordsCarryTheirAmplitude) {
  const Found found = find(bear({{20, 200}}));
  ASSERT_EQ(found.peaks.size, 1);
  EXPECT_EQ(found.peaks[0], 0x8000 | 20 << 8 | 200);
}

TEST(FreeSpaceTwin, EvenDistancesCountTheMiddleBinTwice) {
  OverflowCounters counters;
  const Valley even = valleyBetween(bear({{10, 8}, {11, 3}, {12, 6}}), 10, 12, counters);
  EXPECT_EQ(even.under.raw(), 8 + 3 + 3 + 6);
  EXPECT_EQ(even.below.raw(), (8 - 3) + (6 - 3));
  const Valley odd = valleyBetween(bear({{10, 8}, {11, 3}, {12, 1}, {13, 6}}), 10, 13, counters);
  EXPECT_EQ(odd.under.raw(), 8 + 3 + 1 + 6);
  EXPECT_EQ(odd.below.raw(), (8 - 3) + (6 - 1));
}

TEST(FreeSpaceTwin, BinsAboveTheirPeakTakeNothingFromTheValley) {
  OverflowCounters counters;
  // The right peak's half holds a bin that belongs to the left one's slope.
  const Valley valley = valleyBetween(bear({{0, 50}, {1, 40}, {2, 0}, {3, 10}}), 0, 3, counters);
  EXPECT_EQ(valley.below.raw(), (50 - 40) + (10 - 0));
  const Valley half = valleyBetween(bear({{0, 9}, {1, 9}, {2, 200}, {3, 10}}), 0, 3, counters);
  EXPECT_EQ(half.below.raw(), 0);
}

TEST(FreeSpaceTwin, ValleyAreaSaturatesAt14BitsAndCountsOnceAPair) {
  OverflowCounters counters;
  const PolarHistogram bins = bear({{0, 255}, {79, 255}});
  const Valley valley = valleyBetween(bins, 0, 79, counters);
  EXPECT_EQ(valley.below.raw(), 16383);  // 78 empty bins of 255: 19890
  EXPECT_EQ(counters[Wire::A2], 1U);
  EXPECT_EQ(counters[Wire::A1], 0U);
  EXPECT_EQ(valley.under.raw(), 510);
}

TEST(FreeSpaceTwin, LargestAreaUnderTheHistogramStillFits) {
  PolarHistogram full{};
  full.fill(255);
  OverflowCounters counters;
  EXPECT_EQ(valleyBetween(full, 0, 79, counters).under.raw(), 80 * 255);
  EXPECT_EQ(counters[Wire::A1], 0U);
}

TEST(FreeSpaceTwin, DeepValleysSeparateAndThePrintedRuleIsTheOpposite) {
  FrameParameters p = test::driveParameters(640, 480);
  const PolarHistogram deep = bear({{10, 100}, {20, 100}});
  PolarHistogram shallow = deep;
  for (std::size_t i = 11; i < 20; ++i) shallow[i] = 90;
  EXPECT_TRUE(peakStartsObstacle(find(deep, p).peaks[1]));
  EXPECT_FALSE(peakStartsObstacle(find(shallow, p).peaks[1]));
  p.free_space_rule = 1;
  EXPECT_FALSE(peakStartsObstacle(find(deep, p).peaks[1]));
  EXPECT_TRUE(peakStartsObstacle(find(shallow, p).peaks[1]));
}

TEST(FreeSpaceTwin, EqualAreasAreOneObstacleUnderBothRules) {
  FrameParameters p = test::driveParameters(640, 480);
  Valley valley;
  valley.under = formats::HistogramArea::fromRaw(60);
  valley.below = formats::ValleyArea::fromRaw(20);
  p.valley_threshold = 3;
  EXPECT_FALSE(separate(valley, p));
  p.free_space_rule = 1;
  EXPECT_FALSE(separate(valley, p));
  p.free_space_rule = 0;
  p.valley_threshold = 4;
  EXPECT_TRUE(separate(valley, p));
}

TEST(FreeSpaceTwin, DropsPeaksPastThe32ndAndCountsThem) {
  PolarHistogram comb{};
  for (std::size_t i = 0; i < line_count; i += 2) comb[i] = 7;
  const Found found = find(comb);
  EXPECT_EQ(found.peaks.size, 32);
  EXPECT_EQ(peakBearing(found.peaks[31]), 62);
  EXPECT_EQ(found.counters[Wire::Peaks], 8U);
}

Contacts contacts(std::initializer_list<std::pair<int, int>> bearing_and_row) {
  Contacts cor{};
  for (const auto& [bearing, v] : bearing_and_row) {
    cor[static_cast<std::size_t>(bearing)] = {true, contactWord(bearing, 8 * bearing + 4, v)};
  }
  return cor;
}

Peaks peaks(std::initializer_list<std::pair<int, bool>> bearing_and_start) {
  Peaks all;
  for (const auto& [bearing, start] : bearing_and_start) all.push(peakWord(start, bearing, 50));
  return all;
}

std::vector<int> selectedBearings(const Contacts& cor, const Peaks& peaks, int tolerance = 1) {
  SelectedContacts selected;
  selectContacts(cor, peaks, tolerance, selected);
  std::vector<int> all;
  for (const std::uint32_t word : selected) all.push_back(wordBearing(word));
  return all;
}

TEST(SelectionTwin, NearestContactOfEveryObstacleIncludingTheLast) {
  const auto all = selectedBearings(contacts({{10, 300}, {20, 350}, {40, 100}, {70, 90}}),
                                    peaks({{10, true}, {20, false}, {40, true}, {70, true}}));
  EXPECT_EQ(all, (std::vector<int>{20, 40, 70}));
}

TEST(SelectionTwin, TiesGoToTheContactNearestItsPeakThenToTheLowerBearing) {
  EXPECT_EQ(selectedBearings(contacts({{9, 300}, {10, 300}, {11, 300}}), peaks({{10, true}})),
            (std::vector<int>{10}));
  EXPECT_EQ(selectedBearings(contacts({{9, 300}, {11, 300}}), peaks({{10, true}})),
            (std::vector<int>{9}));
}

TEST(SelectionTwin, AContactServesOnlyTheNearestPeak) {
  // Bearing 12 is equally near to both peaks: it serves 10, not 14.
  const auto two = peaks({{10, true}, {14, true}});
  EXPECT_EQ(selectedBearings(contacts({{12, 400}, {14, 100}}), two, 5), (std::vector<int>{12, 14}));
  EXPECT_EQ(servedPeak(two, 12), 0);
  EXPECT_EQ(servedPeak(two, 13), 1);
}

TEST(SelectionTwin, AnObstacleWithoutACandidateGivesNoWord) {
  EXPECT_TRUE(selectedBearings(contacts({{30, 300}}), peaks({{10, true}})).empty());
  EXPECT_TRUE(selectedBearings(contacts({{30, 300}}), Peaks{}).empty());
}

TEST(SelectionTwin, ToleranceIsInclusive) {
  EXPECT_EQ(selectedBearings(contacts({{13, 300}}), peaks({{10, true}}), 3).size(), 1U);
  EXPECT_TRUE(selectedBearings(contacts({{13, 300}}), peaks({{10, true}}), 2).empty());
}

}  // namespace
}  // namespace ipm_mapping::fpga
