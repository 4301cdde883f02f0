#include "ipm_mapping/ros/scan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace ipm_mapping {
namespace {

/// A view of +-`half` radians whose camera stands at `foot` on the base.
Obstacles view(int bearings, double half, const Eigen::Vector2d& foot, double yaw = 0.0) {
  Obstacles o;
  o.max_range = 2.0;
  o.view.T_base_camera = cameraPose(foot.x(), foot.y(), 0.45, 0.4, yaw);
  for (int i = 0; i < bearings; ++i) {
    const double t = 1.0 - 2.0 * (i + 0.5) / bearings;
    o.bearings.push_back(
        {static_cast<float>(wrapAngle(yaw + half * t)), 0.0F, 5.0F, 0.3F, BearingState::Free});
  }
  return o;
}

sensor_msgs::LaserScan scanOf(const Obstacles& o, const OutputParameters& p = {}) {
  sensor_msgs::LaserScan scan;
  toScan(o, p, scan);
  return scan;
}

/// Value of the scan in the direction of a point of the base frame.
float towards(const sensor_msgs::LaserScan& scan, double x, double y) {
  double angle = std::atan2(y, x);
  while (angle < scan.angle_min - 0.5 * scan.angle_increment) angle += 2 * M_PI;
  return scan.ranges.at(
      static_cast<std::size_t>(std::lround((angle - scan.angle_min) / scan.angle_increment)));
}

TEST(Scan, FreeFloorUpToTheEndIsInfinity) {
  const auto scan = scanOf(view(80, 0.5, {0.1, 0}));
  ASSERT_EQ(scan.ranges.size(), 80U);
  for (float range : scan.ranges) EXPECT_TRUE(std::isinf(range) && range > 0) << range;
  EXPECT_FLOAT_EQ(scan.range_max, 2.0F);
  EXPECT_GT(scan.range_min, 0.0F);
}

TEST(Scan, FloorSeenOnlyInPartIsNotANumber) {
  Obstacles o = view(40, 0.5, {0, 0});
  o.bearings[10].range = 1.2F;
  o.bearings[20].state = BearingState::Unknown;
  o.bearings[30].state = BearingState::Blocked;
  o.bearings[30].range = 0.3F;
  const auto scan = scanOf(o);
  int unknown = 0;
  for (float range : scan.ranges) unknown += std::isnan(range);
  EXPECT_EQ(unknown, 3);
  EXPECT_TRUE(std::isnan(scan.ranges[39 - 10]));
  EXPECT_TRUE(std::isnan(scan.ranges[39 - 20]));
  EXPECT_TRUE(std::isnan(scan.ranges[39 - 30]));
}

TEST(Scan, FloorThatEndsAtTheLastRowInFrontOfTheEndIsSeenUpToTheEnd) {
  // Rows of the picture are 3.5 cm of floor apart at 2 m: the last one may be that far in front.
  Obstacles o = view(40, 0.5, {0, 0});
  o.view.camera = CameraModel({320, 240, 260, 260, 159.5, 119.5}, {});
  for (Bearing& b : o.bearings) b.range = 1.97F;
  o.bearings[20].range = 1.85F;
  const auto scan = scanOf(o);
  EXPECT_EQ(
      std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float r) { return std::isinf(r); }),
      39);
  EXPECT_TRUE(std::isnan(scan.ranges[39 - 20]));
}

TEST(Scan, RangesCountFromTheBaseOriginWhereverTheCameraStands) {
  for (const Eigen::Vector2d& foot : {Eigen::Vector2d(0.3, 0.1), Eigen::Vector2d(-0.4, -0.2)}) {
    Obstacles o = view(80, 0.5, foot);
    for (std::size_t i : {5U, 30U, 41U, 70U}) {
      o.bearings[i].state = BearingState::Occupied;
      o.bearings[i].range = 1.0F;
    }
    const auto scan = scanOf(o);
    for (std::size_t i : {5U, 30U, 41U, 70U}) {
      const double a = o.bearings[i].angle;
      const Eigen::Vector2d p = foot + Eigen::Vector2d(std::cos(a), std::sin(a));
      EXPECT_NEAR(towards(scan, p.x(), p.y()), p.norm(), 1e-5) << i;
    }
  }
}

TEST(Scan, NearestObstacleOfACellWins) {
  // Four times as many bearings on the right half as on the left: several share a cell there.
  Obstacles o;
  o.max_range = 2.0;
  for (double a = 0.5; a > -0.5; a -= a > 0 ? 0.04 : 0.01)
    o.bearings.push_back({static_cast<float>(a), 0, 5.0F, 0.3F, BearingState::Free});
  for (Bearing& b : o.bearings)
    if (b.angle < -0.2F && b.angle > -0.3F) b = {b.angle, 0, 1.5F, 0.3F, BearingState::Occupied};
  for (Bearing& b : o.bearings)
    if (std::abs(b.angle + 0.25F) < 0.005F) b.range = 0.8F;
  const auto scan = scanOf(o);
  EXPECT_FLOAT_EQ(towards(scan, std::cos(-0.25), std::sin(-0.25)), 0.8F);
  EXPECT_FLOAT_EQ(towards(scan, std::cos(-0.28), std::sin(-0.28)), 1.5F);
}

TEST(Scan, GridIsUniformAndHoldsEveryBearing) {
  const Obstacles o = view(61, 0.6, {0.2, 0.0});
  const auto scan = scanOf(o);
  EXPECT_NEAR(scan.angle_max, scan.angle_min + 60 * scan.angle_increment, 1e-6);
  EXPECT_GT(scan.angle_increment, 0.0F);
  for (const Bearing& b : o.bearings) {
    const double x = 0.2 + 2.0 * std::cos(b.angle), y = 2.0 * std::sin(b.angle);
    EXPECT_GE(std::atan2(y, x), scan.angle_min - 0.51 * scan.angle_increment);
    EXPECT_LE(std::atan2(y, x), scan.angle_max + 0.51 * scan.angle_increment);
  }
}

TEST(Scan, CameraThatLooksBackKeepsItsView) {
  Obstacles o = view(80, 0.5, {-0.1, 0.0}, M_PI);
  o.bearings[40].state = BearingState::Occupied;
  o.bearings[40].range = 1.0F;
  const auto scan = scanOf(o);
  EXPECT_LT(scan.angle_increment * 80, 1.2);
  const double a = o.bearings[40].angle;
  EXPECT_NEAR(towards(scan, -0.1 + std::cos(a), std::sin(a)), 1.1, 1e-3);
}

TEST(Scan, ShorterRangeMaxOpensWhatWasSeenThatFar) {
  Obstacles o = view(40, 0.5, {0, 0});
  o.bearings[20].state = BearingState::Occupied;
  o.bearings[20].range = 1.5F;
  OutputParameters p;
  p.scan_range_max = 1.0;
  auto scan = scanOf(o, p);
  EXPECT_FLOAT_EQ(scan.range_max, 1.0F);
  for (float range : scan.ranges) EXPECT_TRUE(std::isinf(range));
  p.scan_range_max = 9.0;  // farther than was looked: nothing more is known
  EXPECT_FLOAT_EQ(scanOf(o, p).range_max, 2.0F);
}

TEST(Scan, NoValueIsEverZeroOrTheMaximum) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> range(0.0F, 2.2F);
  std::uniform_int_distribution<int> state(0, 3);
  for (int n = 0; n < 300; ++n) {
    Obstacles o = view(1 + n % 97, 0.6, {0.4 * std::sin(n), 0.2 * std::cos(n)});
    for (Bearing& b : o.bearings) {
      b.state = static_cast<BearingState>(state(random));
      b.range = n % 7 == 0 ? 2.0F : range(random);
    }
    const auto scan = scanOf(o);
    ASSERT_EQ(scan.ranges.size(), o.bearings.size());
    for (float r : scan.ranges) {
      if (!std::isfinite(r)) continue;
      EXPECT_GT(r, scan.range_min);
      EXPECT_LT(r, scan.range_max);
    }
  }
}

TEST(Scan, ContactIsNeverLostBesideAnUnknownBearing) {
  Obstacles o = view(80, 0.5, {0.3, 0.0});
  for (Bearing& b : o.bearings) b.state = BearingState::Unknown;
  o.bearings[12].state = BearingState::Occupied;
  o.bearings[12].range = 0.6F;
  const auto scan = scanOf(o);
  int finite = 0;
  for (float r : scan.ranges) finite += std::isfinite(r);
  EXPECT_GE(finite, 1);
}

TEST(Scan, NoBearingsGiveAnEmptyScan) {
  Obstacles o;
  o.max_range = 2.0;
  EXPECT_TRUE(scanOf(o).ranges.empty());
}

}  // namespace
}  // namespace ipm_mapping
