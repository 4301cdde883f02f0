#include "ipm_mapping/sweep/free_floor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ipm_mapping::sweep {
namespace {

/// Twenty-one bearings of three degrees around the x axis, all free up to 2 m; the camera's foot is
/// the base, the floor comes into view at 0.4 m.
class Free : public ::testing::Test {
 protected:
  static constexpr int middle = 10;
  static constexpr double step = 3.0 * M_PI / 180.0;

  void SetUp() override {
    parameters.free_halo = 1;
    free_floor.configure(parameters);
    newFrame(0.0);
  }
  void newFrame(double stamp) {
    obstacles.clear();
    obstacles.view.stamp = stamp;
    obstacles.view.T_base_camera = cameraPose(0.0, 0.0, 0.45, 0.42);
    for (int i = -middle; i <= middle; ++i)
      obstacles.bearings.push_back(
          {static_cast<float>(-i * step), 0.0F, 2.0F, 0.4F, BearingState::Free});
  }
  void contact(int bearing, double range) {
    Bearing& b = at(bearing);
    b.state = BearingState::Occupied;
    b.range = static_cast<float>(range);
    Contact c;
    c.bearing = bearing;
    c.p_base = Eigen::Vector2f(range * std::cos(b.angle), range * std::sin(b.angle));
    obstacles.contacts.push_back(c);
  }
  Bearing& at(int i) { return obstacles.bearings[static_cast<std::size_t>(i)]; }
  void limit(const SE2& pose = {}) {
    free_floor.limit(obstacles);
    free_floor.limitBelowTheView(pose, obstacles.view.stamp, obstacles);
  }

  FreeFloorParameters parameters;
  FreeFloor free_floor;
  Obstacles obstacles;
};

TEST_F(Free, WithoutContactsNothingChanges) {
  limit();
  for (const Bearing& b : obstacles.bearings) {
    EXPECT_EQ(b.state, BearingState::Free);
    EXPECT_EQ(b.range, 2.0F);
  }
}

TEST_F(Free, BesideAContactNothingFartherIsFree) {
  contact(middle, 1.0);
  limit();
  EXPECT_EQ(at(middle - 1).range, 1.0F);
  EXPECT_EQ(at(middle + 1).range, 1.0F);
  EXPECT_EQ(at(middle + 2).range, 2.0F);
}

TEST_F(Free, ANarrowGapIsClosedByTheLineBetweenItsContacts) {
  contact(middle - 2, 1.0);
  contact(middle + 2, 1.15);  // 0.27 m apart
  limit();
  const float between = at(middle).range;
  EXPECT_GT(between, 1.0F);
  EXPECT_LT(between, 1.15F);
  // the middle ray is the x axis: there the line between the two points has y = 0
  const Eigen::Vector2f p = obstacles.contacts[0].p_base, q = obstacles.contacts[1].p_base;
  EXPECT_NEAR(between, p.x() + (q.x() - p.x()) * p.y() / (p.y() - q.y()), 1e-4);
}

TEST_F(Free, ADoorStaysOpen) {
  contact(middle - 7, 1.0);
  contact(middle + 7, 1.0);  // 0.72 m apart
  limit();
  for (int i = middle - 5; i <= middle + 5; ++i) EXPECT_EQ(at(i).range, 2.0F) << i;
}

TEST_F(Free, ASlitBetweenFreeBeamsIsFreeButNotASector) {
  at(4).state = BearingState::Unknown;
  at(4).range = 0.0F;
  at(5).range = 1.5F;
  at(12).state = at(13).state = BearingState::Unknown;
  at(16).state = BearingState::Blocked;
  limit();
  EXPECT_EQ(at(4).state, BearingState::Free);
  EXPECT_EQ(at(4).range, 1.5F);
  EXPECT_EQ(at(12).state, BearingState::Unknown);
  EXPECT_EQ(at(13).state, BearingState::Unknown);
  EXPECT_EQ(at(16).state, BearingState::Blocked);
}

TEST_F(Free, WhatPassedBelowTheViewStillHidesTheFloor) {
  contact(middle, 0.5);
  limit();
  newFrame(0.5);
  limit({0.2, 0.0, 0.0});  // the contact is 0.3 m away now, the view begins at 0.4 m
  EXPECT_EQ(at(middle).state, BearingState::Blocked);
  EXPECT_EQ(at(middle + 4).state, BearingState::Free);
}

/// A wall beside the robot, seen thirty times a second, does not push out what passed below.
TEST_F(Free, ItIsNotForgottenForWhatIsSeenOverAndOver) {
  contact(middle, 0.5);
  limit();
  for (int k = 1; k <= 300; ++k) {
    newFrame(k / 30.0);
    for (int i = 0; i < 8; ++i) contact(i, 0.5);
    limit({0.2, 0.0, 0.0});
    ASSERT_EQ(at(middle).state, BearingState::Blocked) << k;
  }
}

/// Beams are closer together than a place is wide.
TEST_F(Free, EveryContactOfAFrameCounts) {
  for (int i = 0; i <= 2 * middle; ++i) contact(i, 0.12);  // six millimetres apart
  limit();
  for (int k = 1; k < 4; ++k) {
    newFrame(0.1 * k);
    limit({0.002 * k, 0.0, 0.0});
    for (int i = 0; i <= 2 * middle; ++i) EXPECT_EQ(at(i).state, BearingState::Blocked) << i;
  }
}

TEST_F(Free, TheOldestIsForgottenFirstWhereThereIsTooMuch) {
  contact(middle, 0.5);
  limit();
  newFrame(0.1);
  limit({0.2, 0.0, 0.0});
  ASSERT_EQ(at(middle).state, BearingState::Blocked);
  for (int k = 0; k < 60; ++k) {
    newFrame(0.2 + 0.1 * k);
    for (int i = 0; i < 10; ++i) contact(i, 0.5);
    limit({0.2, 5.0 + 2.0 * k, 0.0});  // far away
  }
  newFrame(7.0);
  limit({0.2, 0.0, 0.0});
  EXPECT_EQ(at(middle).state, BearingState::Free);
}

TEST_F(Free, WhatMovesDoesNotStayBelowTheView) {
  contact(middle, 0.5);
  obstacles.contacts.back().moving = true;
  limit();
  newFrame(0.5);
  limit({0.2, 0.0, 0.0});
  EXPECT_EQ(at(middle).state, BearingState::Free);
}

TEST_F(Free, NothingStretchesToWhatMoves) {
  contact(middle, 0.5);
  contact(middle + 2, 0.5);
  obstacles.contacts.back().moving = true;
  limit();
  newFrame(0.5);
  limit({0.2, 0.0, 0.0});
  EXPECT_EQ(at(middle).state, BearingState::Blocked);
  EXPECT_EQ(at(middle + 3).state, BearingState::Free);
}

TEST_F(Free, ARobotThatTurnsKeepsItInItsDirection) {
  contact(middle, 0.5);
  limit();
  newFrame(0.5);
  limit({0.2, 0.0, 4 * step});  // turned left by four bearings: it lies four to the right
  EXPECT_EQ(at(middle).state, BearingState::Free);
  EXPECT_EQ(at(middle + 4).state, BearingState::Blocked);
}

TEST_F(Free, BackInViewTheViewDecides) {
  contact(middle, 0.5);
  limit();
  newFrame(0.5);
  limit({0.2, 0.0, 0.0});
  newFrame(2.0);
  limit({-0.2, 0.0, 0.0});  // 0.7 m away, and nothing is seen there
  EXPECT_EQ(at(middle).state, BearingState::Free);
  newFrame(2.5);
  limit({0.2, 0.0, 0.0});
  EXPECT_EQ(at(middle).state, BearingState::Free);
}

TEST_F(Free, ComingNearerTheBeamsBetweenTwoContactsOfOneThingAreBlockedToo) {
  contact(middle, 0.5);
  contact(middle + 1, 0.5);
  limit();
  newFrame(0.5);
  limit({0.4, 0.0, 0.0});  // 0.1 m away, the two contacts are five bearings apart
  for (int i = middle; i <= middle + 5; ++i) EXPECT_EQ(at(i).state, BearingState::Blocked) << i;
  EXPECT_EQ(at(middle - 1).state, BearingState::Free);
  EXPECT_EQ(at(middle + 6).state, BearingState::Free);
}

TEST_F(Free, AThingThatReachesOutOfTheViewBlocksUpToItsBorder) {
  contact(middle + 4, 0.5);
  contact(middle + 6, 0.5);
  limit();
  newFrame(0.5);
  limit({0.26, 0.0, 0.0});  // its ends are 18 and 22 bearings from the left, the view has 21
  for (int i = middle + 8; i <= 2 * middle; ++i) EXPECT_EQ(at(i).state, BearingState::Blocked) << i;
  EXPECT_EQ(at(middle + 6).state, BearingState::Free);
}

TEST_F(Free, WhatOfAThingIsInViewIsLeftToTheView) {
  contact(middle, 0.42);
  contact(middle + 2, 0.68);
  limit();
  newFrame(0.5);
  limit({0.05, 0.0, 0.0});  // 0.37 and 0.63 m away
  EXPECT_EQ(at(middle).state, BearingState::Blocked);
  EXPECT_EQ(at(middle + 2).state, BearingState::Free);
}

TEST_F(Free, WhatTheRobotHasPassedBlocksNothing) {
  contact(middle, 0.5);
  contact(middle + 1, 0.5);
  limit();
  newFrame(0.5);
  limit({0.8, -0.013, 0.0});  // between the two
  for (const Bearing& b : obstacles.bearings) EXPECT_EQ(b.state, BearingState::Free);
}

TEST_F(Free, BetweenTwoThingsTheFloorStaysFree) {
  contact(middle, 0.5);
  contact(middle + 4, 0.5);
  limit();
  newFrame(0.5);
  limit({0.2, 0.0, 0.0});
  EXPECT_EQ(at(middle).state, BearingState::Blocked);
  EXPECT_EQ(at(middle + 2).state, BearingState::Free);
  EXPECT_EQ(at(middle + 7).state, BearingState::Blocked);
}

TEST_F(Free, MemoryEndsWithItsTimeAndAReset) {
  const SE2 nearer{0.2, 0.0, 0.0};
  contact(middle, 0.5);
  limit();
  newFrame(parameters.near_memory + 1.0);
  limit(nearer);
  EXPECT_EQ(at(middle).state, BearingState::Free);

  contact(middle, 0.5);
  limit();
  free_floor.reset();
  newFrame(parameters.near_memory + 2.0);
  limit(nearer);
  EXPECT_EQ(at(middle).state, BearingState::Free);
}

TEST_F(Free, AContactIsNeverOverruled) {
  contact(middle, 0.5);
  limit();
  newFrame(0.5);
  contact(middle, 1.0);
  limit({0.2, 0.0, 0.0});
  EXPECT_EQ(at(middle).state, BearingState::Occupied);
  EXPECT_EQ(at(middle).range, 1.0F);
}

}  // namespace
}  // namespace ipm_mapping::sweep
