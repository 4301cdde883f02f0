#include "ipm_mapping/stages/selection.hpp"

#include <gtest/gtest.h>

#include <tuple>

#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

using Candidates = std::vector<SelectionCandidate>;
using Indices = std::vector<int>;

Peak first(int bearing) { return {bearing, 1, true}; }
Peak more(int bearing) { return {bearing, 1, false}; }

Indices chosen(const std::vector<Peak>& peaks, const Candidates& candidates, int tolerance = 1) {
  Indices result;
  selectContacts(peaks, candidates, tolerance, result);
  return result;
}

TEST(Selection, TakesTheNearestOfAnObstacle) {
  EXPECT_EQ(chosen({first(10)}, {{9, 1.5}, {10, 1.4}, {11, 1.6}}), Indices({1}));
}

TEST(Selection, DoesNotLoseTheLastObstacle) {
  EXPECT_EQ(chosen({first(10), first(20)}, {{10, 1.0}, {20, 0.5}}), Indices({0, 1}));
}

TEST(Selection, EveryObstacleStartsWithAnEmptyList) {
  // The first obstacle's contact is by far the nearest: it must not win the second obstacle too.
  EXPECT_EQ(chosen({first(10), first(20), first(30)}, {{10, 0.3}, {20, 1.8}, {30, 1.9}}),
            Indices({0, 1, 2}));
}

TEST(Selection, PeaksOfOneObstacleShareOneContact) {
  EXPECT_EQ(chosen({first(10), more(14), first(30)}, {{10, 1.2}, {14, 1.1}, {30, 1.0}}),
            Indices({1, 2}));
}

TEST(Selection, ContactServesTheNearestPeakOnly) {
  // Bearing 12 lies within tolerance of both peaks but nearer to the second.
  EXPECT_EQ(chosen({first(10), first(13)}, {{12, 1.0}}, 2), Indices({0}));
  EXPECT_EQ(chosen({first(10), first(13)}, {{10, 1.2}, {12, 1.0}}, 2), Indices({0, 1}));
}

TEST(Selection, ContactBetweenTwoPeaksServesTheLowerBearing) {
  EXPECT_EQ(chosen({first(10), first(12)}, {{11, 1.0}, {12, 2.0}}), Indices({0, 1}));
  EXPECT_EQ(chosen({first(10), first(12)}, {{10, 2.0}, {11, 1.0}}), Indices({1}));
}

TEST(Selection, DropsContactsOutsideTheTolerance) {
  EXPECT_EQ(chosen({first(10)}, {{8, 0.1}, {12, 0.1}}), Indices());
  EXPECT_EQ(chosen({first(10)}, {{8, 0.1}}, 2), Indices({0}));
  EXPECT_EQ(chosen({first(10)}, {{9, 0.1}, {10, 0.5}}, 0), Indices({1}));
}

TEST(Selection, OnATieTakesTheOneAtThePeakThenTheLowerBearing) {
  EXPECT_EQ(chosen({first(10)}, {{9, 1.0}, {10, 1.0}}), Indices({1}));
  EXPECT_EQ(chosen({first(10)}, {{11, 1.0}, {9, 1.0}}), Indices({1}));
}

TEST(Selection, IsEmptyWithoutPeaksOrContacts) {
  EXPECT_EQ(chosen({}, {{5, 1.0}}), Indices());
  EXPECT_EQ(chosen({first(5)}, {}), Indices());
}

TEST(Selection, EqualsBruteForceOnRandomInput) {
  std::mt19937 random(12);
  for (int round = 0; round < 3000; ++round) {
    std::vector<Peak> peaks;
    for (int bearing = draw(random, 0, 3); bearing < 24; bearing += draw(random, 2, 6))
      peaks.push_back({bearing, 1, peaks.empty() || draw(random, 0, 1) == 1});
    Candidates candidates;
    for (int bearing = 0; bearing < 24; ++bearing)
      if (draw(random, 0, 1)) candidates.push_back({bearing, draw(random, 1, 4) * 0.5});
    const int tolerance = draw(random, 0, 3);

    Indices expected;
    for (std::size_t p = 0; p < peaks.size(); ++p) {
      if (!peaks[p].new_obstacle) continue;
      std::vector<std::tuple<double, int, int, int>> runners;
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        std::tuple<int, int, std::size_t> nearest{1000, 0, 0};
        for (std::size_t q = 0; q < peaks.size(); ++q)
          nearest = std::min(
              nearest, {std::abs(peaks[q].bearing - candidates[c].bearing), peaks[q].bearing, q});
        std::size_t owner = std::get<2>(nearest);
        while (!peaks[owner].new_obstacle) --owner;
        if (owner == p && std::get<0>(nearest) <= tolerance)
          runners.emplace_back(candidates[c].range, std::get<0>(nearest), candidates[c].bearing,
                               static_cast<int>(c));
      }
      if (!runners.empty())
        expected.push_back(std::get<3>(*std::min_element(runners.begin(), runners.end())));
    }
    ASSERT_EQ(chosen(peaks, candidates, tolerance), expected) << round;
  }
}

}  // namespace
}  // namespace ipm_mapping::test
