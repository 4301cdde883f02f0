#include "ipm_mapping/mapping/ray_casting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace ipm_mapping {
namespace {

using Cells = std::set<std::pair<int, int>>;

std::vector<Cell> walk(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  std::vector<Cell> cells;
  forEachCellOnSegment(from, to, [&](const Cell& cell) { cells.push_back(cell); });
  return cells;
}

Cells asSet(const std::vector<Cell>& cells) {
  Cells set;
  for (const Cell& cell : cells) set.insert({cell.x, cell.y});
  return set;
}

/// The cells of many points on the segment: each of them has to be walked through.
Cells supersampled(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int samples) {
  Cells set;
  for (int i = 0; i <= samples; ++i) {
    const Cell cell = cellOf(from + (to - from) * (static_cast<double>(i) / samples));
    set.insert({cell.x, cell.y});
  }
  return set;
}

/// Slab test: does the segment meet the cell's square, widened by `margin`?
bool meets(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Cell& cell,
           double margin) {
  double enters = 0.0, leaves = 1.0;
  const Eigen::Vector2d d = to - from;
  const Eigen::Vector2d corner(cell.x, cell.y);
  for (int axis = 0; axis < 2; ++axis) {
    const double low = corner[axis] - margin, high = corner[axis] + 1.0 + margin;
    if (d[axis] == 0.0) {
      if (from[axis] < low || from[axis] > high) return false;
      continue;
    }
    const double a = (low - from[axis]) / d[axis], b = (high - from[axis]) / d[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return enters <= leaves;
}

/// `walked` is right for the segment: complete, connected, and nothing beside it.
void expectExact(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const std::vector<Cell> walked = walk(from, to);
  const Cells set = asSet(walked);
  ASSERT_EQ(walked.front(), cellOf(from));
  ASSERT_EQ(walked.back(), cellOf(to));
  ASSERT_EQ(set.size(), walked.size()) << "a cell twice";
  for (std::size_t i = 1; i < walked.size(); ++i)
    ASSERT_EQ(std::abs(walked[i].x - walked[i - 1].x) + std::abs(walked[i].y - walked[i - 1].y), 1);
  for (const Cell& cell : walked)
    ASSERT_TRUE(meets(from, to, cell, 1e-9)) << "cell " << cell.x << ", " << cell.y;
  for (const auto& [x, y] : supersampled(from, to, 4000))
    ASSERT_TRUE(set.count({x, y})) << "cell " << x << ", " << y << " left out of "
                                   << from.transpose() << " - " << to.transpose();
}

TEST(RayCasting, AgreesWithSupersamplingAndSlabTestInEveryDirection) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-40.0, 40.0);
  for (int i = 0; i < 2000; ++i)
    expectExact({coordinate(random), coordinate(random)}, {coordinate(random), coordinate(random)});
}

TEST(RayCasting, StaysConnectedOnGridLinesAndThroughCorners) {
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y)
      for (const double offset : {0.0, 0.5}) {
        const Eigen::Vector2d from(offset, offset), to(x + offset, y + offset);
        const std::vector<Cell> walked = walk(from, to);
        EXPECT_EQ(walked.front(), cellOf(from));
        EXPECT_EQ(walked.back(), cellOf(to));
        EXPECT_EQ(walked.size(), static_cast<std::size_t>(std::abs(x) + std::abs(y)) + 1);
        for (const Cell& cell : walked) EXPECT_TRUE(meets(from, to, cell, 1e-9));
      }
}

TEST(RayCasting, AxisParallelRaysKeepTheirRow) {
  const std::vector<Cell> walked = walk({-2.5, -0.25}, {1.5, -0.25});
  ASSERT_EQ(walked.size(), 5U);
  for (std::size_t i = 0; i < walked.size(); ++i)
    EXPECT_EQ(walked[i], (Cell{static_cast<int>(i) - 3, -1}));
}

TEST(RayCasting, APointIsOneCell) {
  const std::vector<Cell> walked = walk({-0.5, 3.0}, {-0.5, 3.0});
  ASSERT_EQ(walked.size(), 1U);
  EXPECT_EQ(walked[0], (Cell{-1, 3}));
}

TEST(RayCasting, LongRaysDoNotDrift) {
  const Eigen::Vector2d from(0.3, 0.7), to(99999.6, 31415.2);
  for (const Cell& cell : walk(from, to)) ASSERT_TRUE(meets(from, to, cell, 1e-6));
}

TEST(RayCasting, FloorsNegativeCoordinates) {
  EXPECT_EQ(cellOf({-0.001, -1.0}), (Cell{-1, -1}));
  EXPECT_EQ(cellOf({0.0, 0.999}), (Cell{0, 0}));
}

}  // namespace
}  // namespace ipm_mapping
