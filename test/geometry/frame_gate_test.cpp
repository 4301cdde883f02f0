#include "ipm_mapping/frame_gate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace ipm_mapping {
namespace {

using Gate = FrameGate<int>;

/// Odometry from `begin` to `end` at 50 Hz, x = t.
void drive(Gate& gate, double begin, double end) {
  for (int i = 0; begin + 0.02 * i <= end + 1e-9; ++i)
    gate.addOdometry(begin + 0.02 * i, {begin + 0.02 * i, 0.0, 0.0});
}
std::vector<int> takeAll(Gate& gate) {
  std::vector<int> taken;
  for (Gate::Released r; gate.next(r);) taken.push_back(r.payload);
  return taken;
}

TEST(FrameGate, HoldsAFrameUntilOdometryHasPassedIt) {
  Gate gate;
  drive(gate, 10.0, 10.10);
  EXPECT_FALSE(gate.addFrame(10.11, 1));
  EXPECT_TRUE(takeAll(gate).empty());
  EXPECT_EQ(gate.waiting(), 1U);
  drive(gate, 10.12, 10.12);
  Gate::Released released;
  ASSERT_TRUE(gate.next(released));
  EXPECT_EQ(released.payload, 1);
  EXPECT_EQ(released.stamp, 10.11);
  EXPECT_NEAR(released.T_odom_base.x, 10.11, 1e-9) << "the pose of the frame's own stamp";
  EXPECT_EQ(gate.waiting(), 0U);
}

TEST(FrameGate, ReleasesInOrderAndStopsAtTheFirstThatHasToWait) {
  Gate gate;
  for (int i = 0; i < 5; ++i) gate.addFrame(10.0 + 0.1 * i, i);
  drive(gate, 9.9, 10.25);
  EXPECT_EQ(takeAll(gate), (std::vector<int>{0, 1, 2}));
  drive(gate, 10.27, 11.0);
  EXPECT_EQ(takeAll(gate), (std::vector<int>{3, 4}));
}

TEST(FrameGate, GivesTheSameFramesInWhateverPiecesTheyArrive) {
  Gate late, early;
  for (int i = 0; i < 20; ++i) late.addFrame(10.03 + 0.03 * i, i);
  drive(late, 10.0, 11.0);
  std::vector<int> piecemeal;
  drive(early, 10.0, 10.0);
  for (int i = 0; i < 20; ++i) {
    early.addFrame(10.03 + 0.03 * i, i);
    const double t = *early.odometry().newest() + 0.02;
    drive(early, t, t + 0.02);
    for (const int frame : takeAll(early)) piecemeal.push_back(frame);
  }
  drive(early, *early.odometry().newest() + 0.02, 11.0);
  for (const int frame : takeAll(early)) piecemeal.push_back(frame);
  EXPECT_EQ(takeAll(late), piecemeal);
  EXPECT_EQ(piecemeal.size(), 20U);
}

TEST(FrameGate, DropsTheOldestWhenTooManyWait) {
  Gate gate({}, 3);
  for (int i = 0; i < 5; ++i) gate.addFrame(10.0 + 0.1 * i, i);
  EXPECT_EQ(gate.waiting(), 3U);
  EXPECT_EQ(gate.dropped(GateDrop::Overflow), 2U);
  drive(gate, 9.9, 11.0);
  EXPECT_EQ(takeAll(gate), (std::vector<int>{2, 3, 4}));
}

TEST(FrameGate, GivesUpOnOdometryThatLagsTooFar) {
  OdometryParameters parameters;
  parameters.wait = 0.5;
  Gate gate(parameters);
  drive(gate, 9.0, 9.5);
  gate.addFrame(10.0, 0);
  gate.addFrame(10.4, 1);
  EXPECT_TRUE(takeAll(gate).empty());
  EXPECT_EQ(gate.waiting(), 2U);
  gate.addFrame(10.6, 2);
  EXPECT_TRUE(takeAll(gate).empty());
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 1U) << "only the first is overdue";
  EXPECT_EQ(gate.waiting(), 2U);
}

TEST(FrameGate, WaitsForOdometryThatArrivesAfterManyImages) {
  Gate gate;  // waits one second
  gate.addOdometry(9.98, {}, 500.0);
  for (int i = 0; i < 30; ++i) {
    gate.addFrame(10.0 + 0.1 * i, i, 500.0 + 0.001 * i);
    EXPECT_TRUE(takeAll(gate).empty());
  }
  std::vector<int> taken;
  for (int k = 0; k <= 150; ++k) {
    gate.addOdometry(10.0 + 0.02 * k, {0.02 * k, 0.0, 0.0}, 500.03);
    for (const int frame : takeAll(gate)) taken.push_back(frame);
  }
  EXPECT_EQ(taken.size(), 30U);
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 0U);
}

TEST(FrameGate, WaitsWhileOdometryMakesProgressAndGivesUpWhenItStops) {
  OdometryParameters parameters;
  parameters.wait = 0.95;
  Gate gate(parameters, 100);
  Gate::Released released;
  // Odometry lags by two seconds, twice what it may stand still.
  int taken = 0;
  for (int i = 0; i < 50; ++i) {
    const double t = 0.1 * i;
    gate.addFrame(10.0 + t, i, t);
    gate.addOdometry(8.05 + t, {}, t);
    while (gate.next(released, t)) ++taken;
  }
  EXPECT_EQ(taken, 30);
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 0U);
  EXPECT_FALSE(gate.next(released, 5.8));
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 0U) << "it stood still for 0.9 s";
  EXPECT_FALSE(gate.next(released, 6.0));
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 10U) << "those so much older than the newest";
  EXPECT_EQ(gate.waiting(), 10U);
}

TEST(FrameGate, GivesUpOnOdometryThatRepeatsItself) {
  Gate gate;
  Gate::Released released;
  gate.addFrame(10.0, 0, 0.0);
  gate.addFrame(11.5, 1, 0.0);
  for (int i = 0; i < 20; ++i) {
    gate.addOdometry(9.0, {}, 0.1 * i);
    EXPECT_FALSE(gate.next(released, 0.1 * i));
  }
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 1U);
}

TEST(FrameGate, GivesUpAfterTheClockWasSetBackToo) {
  Gate gate;
  drive(gate, 100.0, 101.0);
  EXPECT_TRUE((gate.addFrame(100.5, 0), gate.addFrame(50.0, 1)));
  gate.addFrame(51.5, 2);
  EXPECT_TRUE(takeAll(gate).empty());
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 1U);
}

TEST(FrameGate, ATimeOffsetMovesStampPoseAndVelocity) {
  for (const double offset : {-0.07, 0.05}) {
    Gate gate;
    gate.setTimeOffset(offset);
    for (int i = 0; i <= 60; ++i) {  // faster and faster
      const double t = 0.02 * i;
      gate.addOdometry(10.0 + t, {0.5 * t * t, 0.0, 0.0});
    }
    gate.addFrame(10.60, 1);
    Gate::Released released;
    ASSERT_TRUE(gate.next(released));
    EXPECT_DOUBLE_EQ(released.stamp, 10.60 + offset) << "the first frame already";
    EXPECT_EQ(released.time_offset, offset);
    EXPECT_NEAR(released.T_odom_base.x, 0.5 * std::pow(0.60 + offset, 2), 1e-4);
    EXPECT_NEAR(released.velocity.x, 0.60 + offset, 0.011);
  }
}

TEST(FrameGate, WaitsForOdometryOfTheMovedStamp) {
  Gate gate;
  gate.setTimeOffset(0.05);
  drive(gate, 10.0, 10.14);
  gate.addFrame(10.10, 1);
  EXPECT_TRUE(takeAll(gate).empty()) << "odometry has passed its stamp, but not the moved one";
  drive(gate, 10.16, 10.16);
  EXPECT_EQ(takeAll(gate), std::vector<int>{1});
}

TEST(FrameGate, AnOffsetThatChangesComesIntoForceBitByBitAndKeepsTheOrder) {
  Gate gate;
  drive(gate, 10.0, 13.0);
  double before = 0.0, offset = 0.0;
  int frames = 0, settled = 0;
  for (int i = 0; i < 60; ++i) {
    gate.setTimeOffset(i < 10 ? 0.0 : i < 35 ? -0.1 : 0.05);
    gate.addFrame(10.5 + 0.03 * i, i);
    Gate::Released released;
    while (gate.next(released)) {
      ++frames;
      EXPECT_GT(released.stamp, before) << "frame " << i;
      EXPECT_NEAR(released.T_odom_base.x, released.stamp, 1e-9);
      EXPECT_NEAR(released.stamp, 10.5 + 0.03 * i + released.time_offset, 1e-9);
      EXPECT_LE(std::abs(released.time_offset - offset), 0.25 * 0.03 + 1e-9);
      before = released.stamp;
      offset = released.time_offset;
      settled += i == 34 && offset == -0.1;
    }
  }
  EXPECT_EQ(frames, 60);
  EXPECT_EQ(settled, 1);
  EXPECT_EQ(offset, 0.05) << "all of it in the end";
}

TEST(FrameGate, AfterTheClockWasSetBackTheOffsetHoldsFromTheFirstFrame) {
  Gate gate;
  drive(gate, 100.0, 101.0);
  gate.addFrame(100.5, 1);
  EXPECT_EQ(takeAll(gate), std::vector<int>{1});
  gate.setTimeOffset(-0.1);
  drive(gate, 10.0, 11.0);
  gate.addFrame(10.5, 2);
  Gate::Released released;
  ASSERT_TRUE(gate.next(released));
  EXPECT_EQ(released.time_offset, -0.1);
}

TEST(FrameGate, CountsFramesThatOdometryCannotPlace) {
  Gate gate;
  gate.addFrame(9.0, 0);
  gate.addFrame(10.5, 1);
  gate.addFrame(12.005, 2);
  drive(gate, 10.0, 10.4);
  drive(gate, 12.0, 12.1);
  EXPECT_EQ(takeAll(gate), (std::vector<int>{2}));
  EXPECT_EQ(gate.dropped(GateDrop::TooOld), 1U);
  EXPECT_EQ(gate.dropped(GateDrop::OdometryGap), 1U);
}

TEST(FrameGate, DropsLateFramesAndBadStamps) {
  Gate gate;
  drive(gate, 9.9, 10.3);
  EXPECT_FALSE(gate.addFrame(10.1, 0));
  EXPECT_FALSE(gate.addFrame(10.1, 1));
  EXPECT_FALSE(gate.addFrame(10.05, 2));
  EXPECT_FALSE(gate.addFrame(std::nan(""), 3));
  EXPECT_FALSE(gate.addFrame(INFINITY, 4));
  EXPECT_FALSE(gate.addFrame(10.2, 5));
  EXPECT_EQ(takeAll(gate), (std::vector<int>{0, 5}));
  EXPECT_EQ(gate.dropped(GateDrop::OutOfOrder), 2U);
  EXPECT_EQ(gate.dropped(GateDrop::BadStamp), 2U);
}

TEST(FrameGate, AClockSetBackForgetsHistoryWhicheverMessageSaysSoFirst) {
  for (const bool odometry_first : {true, false}) {
    Gate gate;
    drive(gate, 100.0, 101.0);
    gate.addFrame(100.5, 0);
    gate.addFrame(101.5, 1);
    EXPECT_EQ(takeAll(gate), (std::vector<int>{0}));
    int resets = 0;
    if (!odometry_first) resets += gate.addFrame(50.01, 2);
    for (int i = 0; i < 5; ++i)
      resets += gate.addOdometry(50.0 + 0.02 * i, {50.0 + 0.02 * i, 0.0, 0.0});
    if (odometry_first) resets += gate.addFrame(50.01, 2);
    EXPECT_EQ(resets, 1) << "told once";
    Gate::Released released;
    ASSERT_TRUE(gate.next(released));
    EXPECT_EQ(released.payload, 2) << "frame 1 waited for odometry that will not come";
    EXPECT_NEAR(released.T_odom_base.x, 50.01, 1e-9) << "a pose of after the jump";
    EXPECT_FALSE(gate.next(released));
    EXPECT_EQ(gate.dropped(GateDrop::ClockJump), 1U) << "frame 1 is accounted for";
  }
}

TEST(FrameGate, APoseJumpForgetsHistoryAndTheFramesBeforeIt) {
  Gate gate;
  drive(gate, 10.0, 10.2);
  gate.addFrame(10.21, 0);
  OdometryVerdict verdict{};
  EXPECT_FALSE(gate.addOdometry(10.22, {500.0, 0.0, 0.0}, &verdict));
  EXPECT_EQ(verdict, OdometryVerdict::Outlier);
  EXPECT_TRUE(gate.addOdometry(10.23, {500.0, 0.0, 0.0}, &verdict));
  EXPECT_EQ(verdict, OdometryVerdict::PoseJump);
  EXPECT_TRUE(takeAll(gate).empty());
  EXPECT_EQ(gate.dropped(GateDrop::TooOld), 1U) << "between two places no pose is known";
  EXPECT_FALSE(gate.addOdometry(10.24, {500.01, 0.0, 0.0}));
  gate.addFrame(10.23, 1);
  EXPECT_EQ(takeAll(gate), (std::vector<int>{1}));
}

TEST(FrameGate, WhatStillWaitsAtTheEndIsCounted) {
  Gate gate;
  gate.addFrame(10.0, 0);
  gate.addFrame(10.1, 1);
  gate.finish();
  EXPECT_EQ(gate.waiting(), 0U);
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 2U);
}

TEST(FrameGate, ReasonsHaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (int i = 0; i < gate_drop_count; ++i) names.insert(name(static_cast<GateDrop>(i)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(gate_drop_count));
}

}  // namespace
}  // namespace ipm_mapping
