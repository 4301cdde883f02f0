#include "ipm_mapping/sweep/map_anchor.hpp"

#include <gtest/gtest.h>

namespace ipm_mapping::sweep {
namespace {

void expectNear(const SE2& a, const SE2& b) {
  EXPECT_NEAR(a.x, b.x, 1e-12);
  EXPECT_NEAR(a.y, b.y, 1e-12);
  EXPECT_NEAR(wrapAngle(a.theta - b.theta), 0.0, 1e-12);
}

const SE2 wheels{2.0, -1.0, 0.4}, refined{2.1, -0.9, 0.3};

TEST(MapAnchor, PutsTheWheelsFrameWhereTheRobotIsWhereTheFloorSaysItIs) {
  MapAnchor anchor;
  expectNear(anchor.follow(wheels, wheels), {});
  const SE2 T_map_odom = anchor.follow(wheels, refined);
  expectNear(T_map_odom * wheels, refined);
}

TEST(MapAnchor, OdometryThatBeginsAnewLeavesTheRobotInItsPlace) {
  MapAnchor anchor;
  anchor.follow(wheels, refined);
  anchor.restart(Restart::Odometry);
  const SE2 zero{0.0, 0.0, 0.1};
  expectNear(anchor.follow(zero, zero) * zero, refined);
  const SE2 on{0.5, 0.0, 0.1}, slipped{0.4, 0.0, 0.2};
  expectNear(anchor.follow(on, slipped) * on, refined * zero.inverse() * slipped);
}

TEST(MapAnchor, WhatWasMissedIsTheWheelsWay) {
  MapAnchor anchor;
  const SE2 T_map_odom = anchor.follow(wheels, refined);
  anchor.restart(Restart::Missed);
  const SE2 elsewhere{5.0, 3.0, -1.0};
  expectNear(anchor.follow(elsewhere, elsewhere), T_map_odom);
  // Missed right after a jump: the robot keeps its place all the same.
  anchor.restart(Restart::Odometry);
  anchor.restart(Restart::Missed);
  expectNear(anchor.follow({}, {}), T_map_odom * elsewhere);
}

TEST(MapAnchor, AClockThatIsSetBackBeginsANewMap) {
  MapAnchor anchor;
  anchor.follow(wheels, refined);
  anchor.restart(Restart::Clock);
  expectNear(anchor.follow(wheels, wheels), {});
  anchor.restart(Restart::Odometry);
  anchor.restart(Restart::Clock);
  expectNear(anchor.follow(wheels, wheels), {});
}

}  // namespace
}  // namespace ipm_mapping::sweep
