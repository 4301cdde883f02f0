#include "ipm_mapping/stages/free_space.hpp"

#include <gtest/gtest.h>

#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

using Bins = std::vector<int>;

std::vector<int> bearingsOf(const std::vector<Peak>& peaks) {
  std::vector<int> bearings;
  for (const Peak& p : peaks) bearings.push_back(p.bearing);
  return bearings;
}

std::vector<int> peaksOf(const Bins& histogram, bool single_bin = false) {
  std::vector<Peak> peaks;
  findPeaks(histogram, single_bin, peaks);
  return bearingsOf(peaks);
}

/// The definition tried on every interval.
std::vector<int> slowPeaks(const Bins& h, bool single_bin) {
  const int n = static_cast<int>(h.size());
  const auto at = [&](int i) { return i < 0 || i >= n ? 0 : h[static_cast<std::size_t>(i)]; };
  std::vector<int> found;
  for (int a = 0; a < n; ++a) {
    for (int b = a; b < n; ++b) {
      bool run = at(a) > 0 && at(a - 1) < at(a) && at(b + 1) < at(b);
      for (int i = a; i <= b; ++i) run = run && at(i) == at(a);
      if (run && (!single_bin || a == b)) found.push_back((a + b) / 2);
    }
  }
  return found;
}

/// Marks of the peaks that begin an obstacle.
std::vector<bool> beginnings(const Bins& histogram, FreeSpaceRule rule, double threshold = 1.0) {
  std::vector<Peak> peaks;
  findPeaks(histogram, false, peaks);
  groupPeaks(histogram, rule, threshold, peaks);
  std::vector<bool> marks;
  for (const Peak& p : peaks) marks.push_back(p.new_obstacle);
  return marks;
}
using Marks = std::vector<bool>;

TEST(Peaks, StandAtTheEndsOfTheHistogram) {
  EXPECT_EQ(peaksOf({5, 3, 0, 0, 2, 4}), Bins({0, 5}));
  EXPECT_EQ(peaksOf({7}), Bins({0}));
  EXPECT_EQ(peaksOf({7, 7, 7, 7}), Bins({1}));
}

TEST(Peaks, AreAbsentFromEmptyHistograms) {
  EXPECT_EQ(peaksOf({}), Bins());
  EXPECT_EQ(peaksOf({0, 0, 0}), Bins());
}

TEST(Peaks, OfAPlateauStandInItsMiddleRoundedDown) {
  EXPECT_EQ(peaksOf({0, 4, 4, 4, 0}), Bins({2}));
  EXPECT_EQ(peaksOf({0, 4, 4, 4, 4, 0}), Bins({2}));
}

TEST(Peaks, DoNotStandOnAShoulder) { EXPECT_EQ(peaksOf({0, 4, 4, 6, 2, 2, 1}), Bins({3})); }

TEST(Peaks, OfOneBinOnlyIgnorePlateaus) { EXPECT_EQ(peaksOf({0, 4, 4, 0, 3, 0}, true), Bins({4})); }

TEST(Peaks, KeepTheirAmplitude) {
  std::vector<Peak> peaks;
  findPeaks({0, 4, 0, 9, 9, 1}, false, peaks);
  ASSERT_EQ(peaks.size(), 2U);
  EXPECT_EQ(peaks[0].amplitude, 4);
  EXPECT_EQ(peaks[1].amplitude, 9);
}

TEST(Peaks, EqualTheDefinitionOnRandomHistograms) {
  std::mt19937 random(10);
  for (int round = 0; round < 3000; ++round) {
    Bins h(static_cast<std::size_t>(draw(random, 0, 14)));
    for (int& bin : h) bin = draw(random, 0, 3);
    for (const bool single : {false, true})
      ASSERT_EQ(peaksOf(h, single), slowPeaks(h, single)) << round;
  }
}

TEST(Valley, AreasAreMeasuredFromEachHalfsOwnPeak) {
  // Peaks 10 at 0 and 4 at 5: halves 0..2 and 3..5.
  const ValleyAreas areas = valleyAreas({10, 3, 1, 2, 3, 4}, {0, 10, true}, {5, 4, false});
  EXPECT_EQ(areas.A1, 10 + 3 + 1 + 2 + 3 + 4);
  EXPECT_EQ(areas.A2, (0 + 7 + 9) + (2 + 1 + 0));
}

TEST(Valley, MiddleOfAnEvenDistanceServesBothHalves) {
  const ValleyAreas areas = valleyAreas({6, 1, 2, 5, 8}, {0, 6, true}, {4, 8, false});
  EXPECT_EQ(areas.A1, (6 + 1 + 2) + (2 + 5 + 8));
  EXPECT_EQ(areas.A2, (0 + 5 + 4) + (6 + 3 + 0));
}

TEST(Valley, BinsAboveTheLowerPeakDoNotCountNegative) {
  // The right half rises over its own peak's level on the way: those bins add nothing to A2.
  const ValleyAreas areas = valleyAreas({9, 0, 7, 6, 0, 5}, {0, 9, true}, {5, 5, false});
  EXPECT_EQ(areas.A2, (0 + 9 + 2) + (0 + 5 + 0));
}

TEST(FreeSpace, DeepValleySeparatesAndShallowDoesNot) {
  EXPECT_EQ(beginnings({9, 0, 0, 0, 9}, FreeSpaceRule::DeepValley), Marks({true, true}));
  EXPECT_EQ(beginnings({9, 8, 8, 8, 9}, FreeSpaceRule::DeepValley), Marks({true, false}));
}

TEST(FreeSpace, PrintedRuleIsTheOtherWayRound) {
  EXPECT_EQ(beginnings({9, 0, 0, 0, 0, 0, 9}, FreeSpaceRule::Printed), Marks({true, false}));
  EXPECT_EQ(beginnings({9, 8, 8, 8, 9}, FreeSpaceRule::Printed), Marks({true, true}));
}

TEST(FreeSpace, EqualAreasAreTheSameObstacleUnderBothRules) {
  const Bins h{8, 0, 8};  // A1 = 8 + 0 + 0 + 8, A2 = 8 + 8
  EXPECT_EQ(beginnings(h, FreeSpaceRule::DeepValley), Marks({true, false}));
  EXPECT_EQ(beginnings(h, FreeSpaceRule::Printed), Marks({true, false}));
}

TEST(FreeSpace, ThresholdWeighsTheValley) {
  const Bins h{8, 0, 8};
  EXPECT_EQ(beginnings(h, FreeSpaceRule::DeepValley, 1.01), Marks({true, true}));
  EXPECT_EQ(beginnings(h, FreeSpaceRule::DeepValley, 0.99), Marks({true, false}));
}

TEST(FreeSpace, SumsStartAnewForEveryPair) {
  // A deep valley first must not make the shallow one behind it look deep, nor the reverse.
  EXPECT_EQ(beginnings({9, 0, 0, 0, 0, 9, 8, 9}, FreeSpaceRule::DeepValley),
            Marks({true, true, false}));
  EXPECT_EQ(beginnings({9, 8, 9, 0, 0, 0, 0, 9}, FreeSpaceRule::DeepValley),
            Marks({true, false, true}));
}

TEST(FreeSpace, EqualsBruteForceOnRandomHistograms) {
  std::mt19937 random(11);
  for (int round = 0; round < 2000; ++round) {
    Bins h(static_cast<std::size_t>(draw(random, 1, 40)));
    for (int& bin : h) bin = draw(random, 0, 20);
    const double threshold = draw(random, 0.2, 3.0);
    std::vector<Peak> peaks;
    findPeaks(h, false, peaks);
    groupPeaks(h, FreeSpaceRule::DeepValley, threshold, peaks);
    for (std::size_t i = 0; i < peaks.size(); ++i) {
      double under = 0, below = 0;
      if (i > 0) {
        const Peak &l = peaks[i - 1], &r = peaks[i];
        for (int j = l.bearing; j <= r.bearing; ++j) {
          const int value = h[static_cast<std::size_t>(j)];
          if (2 * (j - l.bearing) <= r.bearing - l.bearing) {
            under += value;
            below += std::max(l.amplitude - value, 0);
          }
          if (2 * (r.bearing - j) <= r.bearing - l.bearing) {
            under += value;
            below += std::max(r.amplitude - value, 0);
          }
        }
      }
      ASSERT_EQ(peaks[i].new_obstacle, i == 0 || below * threshold > under) << round;
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::test
