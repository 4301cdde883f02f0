#include "ipm_mapping/geometry/odometry_buffer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace ipm_mapping {
namespace {

using Verdict = OdometryVerdict;

/// 50 Hz, straight ahead with 0.5 m/s from t = 100.
OdometryBuffer driving(int messages = 51) {
  OdometryBuffer buffer;
  for (int i = 0; i < messages; ++i)
    EXPECT_EQ(buffer.add(100.0 + 0.02 * i, {0.01 * i, 0.0, 0.0}), Verdict::Accepted);
  return buffer;
}

TEST(OdometryBuffer, InterpolatesBetweenTheTwoNeighbours) {
  const OdometryBuffer buffer = driving();
  for (const double t : {100.0, 100.013, 100.5, 100.9999, 101.0}) {
    SE2 pose;
    ASSERT_EQ(buffer.at(t, pose), PoseAnswer::Known) << t;
    EXPECT_NEAR(pose.x, 0.5 * (t - 100.0), 1e-9) << t;
  }
}

TEST(OdometryBuffer, InterpolatesAnglesTheShortWayRound) {
  OdometryBuffer buffer;
  buffer.add(0.0, {0.0, 0.0, M_PI - 0.1});
  buffer.add(0.1, {1.0, 0.0, -M_PI + 0.3});
  SE2 pose;
  ASSERT_EQ(buffer.at(0.025, pose), PoseAnswer::Known);
  EXPECT_NEAR(wrapAngle(pose.theta - M_PI), 0.0, 1e-12);
}

TEST(OdometryBuffer, KnowsTheVelocityInTheRobotsOwnAxes) {
  OdometryBuffer buffer;  // an arc of 0.5 m/s and 0.4 rad/s, the robot looks to the left
  const auto onArc = [](double t) {
    const double angle = 0.4 * t, radius = 0.5 / 0.4;
    const SE2 from{1.0, 2.0, M_PI / 2.0};
    return from * SE2{radius * std::sin(angle), radius * (1.0 - std::cos(angle)), angle};
  };
  for (int i = 0; i <= 50; ++i) buffer.add(100.0 + 0.02 * i, onArc(0.02 * i));
  for (const double t : {100.0, 100.01, 100.5, 100.508, 101.0}) {
    const Velocity v = buffer.velocity(t);
    EXPECT_NEAR(v.x, 0.5, 1e-6) << t;
    EXPECT_NEAR(v.y, 0.0, 1e-6) << t;
    EXPECT_NEAR(v.theta, 0.4, 1e-6) << t;
  }
  EXPECT_FALSE(buffer.velocity(101.5).moving()) << "nothing is known of that";
  EXPECT_FALSE(OdometryBuffer().velocity(1.0).moving());
}

/// Two messages a millisecond apart say nothing of a velocity: encoders have steps.
TEST(OdometryBuffer, TheVelocityIsAMeanOverAFewMessages) {
  OdometryBuffer buffer;
  double x = 0.0;
  for (int i = 0; i < 100; ++i) buffer.add(0.01 * i, {x += i % 2 == 0 ? 0.0 : 0.006, 0.0, 0.0});
  for (const double t : {0.3, 0.304, 0.315}) EXPECT_NEAR(buffer.velocity(t).x, 0.3, 0.065) << t;
}

TEST(OdometryBuffer, MessagesTooCloseTogetherOrTooFarApartTellNoVelocity) {
  OdometryBuffer close;
  close.add(1.0, {});
  close.add(1.000001, {0.01, 0.0, 0.0});
  EXPECT_FALSE(close.velocity(1.0).moving());
  OdometryParameters parameters;
  OdometryBuffer far(parameters);
  far.add(1.0, {});
  far.add(1.1 + parameters.max_gap, {0.1, 0.0, 0.0});
  EXPECT_FALSE(far.velocity(1.0).moving());
}

/// It is the velocity at the stamp, not of a while ago: a turn begins.
TEST(OdometryBuffer, TheVelocityIsThatOfTheStamp) {
  OdometryBuffer buffer;
  for (int i = 0; i <= 50; ++i)
    buffer.add(0.02 * i, {0.0, 0.0, i <= 25 ? 0.0 : 0.5 * 0.02 * (i - 25)});
  EXPECT_NEAR(buffer.velocity(0.45).theta, 0.0, 1e-9);
  EXPECT_NEAR(buffer.velocity(0.55).theta, 0.5, 1e-9);
}

TEST(OdometryBuffer, SaysWhyItDoesNotKnow) {
  SE2 pose{7.0, 7.0, 7.0};
  EXPECT_EQ(OdometryBuffer().at(1.0, pose), PoseAnswer::NotYet);
  const OdometryBuffer buffer = driving();
  EXPECT_EQ(buffer.at(101.001, pose), PoseAnswer::NotYet);
  EXPECT_EQ(buffer.at(99.999, pose), PoseAnswer::TooOld);
  EXPECT_EQ(pose.x, 7.0) << "left alone unless the answer is known";
}

TEST(OdometryBuffer, DoesNotInterpolateAcrossAGapButKnowsItsEnds) {
  OdometryParameters parameters;
  parameters.max_gap = 0.5;
  OdometryBuffer buffer(parameters);
  for (const double t : {0.0, 0.5, 1.25, 1.5}) buffer.add(t, {t, 0.0, 0.0});
  SE2 pose;
  EXPECT_EQ(buffer.at(0.3, pose), PoseAnswer::Known) << "0.5 s is not farther apart than 0.5 s";
  EXPECT_EQ(buffer.at(0.75, pose), PoseAnswer::Gap);
  EXPECT_EQ(buffer.at(0.5, pose), PoseAnswer::Known);
  EXPECT_EQ(buffer.at(1.25, pose), PoseAnswer::Known);
  EXPECT_EQ(pose.x, 1.25);
}

TEST(OdometryBuffer, DropsWhatIsNotFiniteDuplicateOrLate) {
  OdometryBuffer buffer = driving();
  const double nan = std::nan("");
  EXPECT_EQ(buffer.add(101.02, {nan, 0, 0}), Verdict::NotFinite);
  EXPECT_EQ(buffer.add(101.02, {0, 0, INFINITY}), Verdict::NotFinite);
  EXPECT_EQ(buffer.add(nan, {0.5, 0, 0}), Verdict::NotFinite);
  EXPECT_EQ(buffer.add(101.0, {9.0, 0, 0}), Verdict::Duplicate);
  EXPECT_EQ(buffer.add(100.995, {9.0, 0, 0}), Verdict::OutOfOrder);
  EXPECT_EQ(buffer.add(100.001, {9.0, 0, 0}), Verdict::OutOfOrder);
  SE2 pose;
  ASSERT_EQ(buffer.at(101.0, pose), PoseAnswer::Known);
  EXPECT_NEAR(pose.x, 0.5, 1e-12);
  EXPECT_EQ(*buffer.newest(), 101.0);
}

TEST(OdometryBuffer, AClockSetBackStartsAnew) {
  OdometryBuffer buffer = driving();
  EXPECT_EQ(buffer.add(50.0, {3.0, 0, 0}), Verdict::TimeJump);
  EXPECT_EQ(*buffer.newest(), 50.0);
  SE2 pose;
  EXPECT_EQ(buffer.at(100.5, pose), PoseAnswer::NotYet) << "what was before is gone";
  EXPECT_EQ(buffer.add(50.02, {3.01, 0, 0}), Verdict::Accepted);
}

TEST(OdometryBuffer, APoseFasterThanTheGateIsDropped) {
  OdometryParameters parameters;
  parameters.max_speed = 2.0;
  parameters.max_turn_rate = 1.0;
  for (const auto& [pose, verdict] :
       {std::pair{SE2{0.19, 0.0, 0.0}, Verdict::Accepted},
        std::pair{SE2{0.21, 0.0, 0.0}, Verdict::Outlier},
        std::pair{SE2{0.0, -0.21, 0.0}, Verdict::Outlier},
        std::pair{SE2{0.0, 0.0, 0.09}, Verdict::Accepted},
        std::pair{SE2{0.0, 0.0, -0.11}, Verdict::Outlier},
        std::pair{SE2{0.0, 0.0, 2.0 * M_PI - 0.05}, Verdict::Accepted}}) {
    OdometryBuffer buffer(parameters);
    buffer.add(10.0, {});
    EXPECT_EQ(buffer.add(10.1, pose), verdict);
    SE2 unused;
    EXPECT_EQ(buffer.at(10.05, unused),
              verdict == Verdict::Accepted ? PoseAnswer::Known : PoseAnswer::NotYet);
  }
}

TEST(OdometryBuffer, AStepThatTheMotionSoFarDoesNotLeadToIsDropped) {
  // 0.5 m/s at 50 Hz: 16 cm aside within 20 ms would be slow enough for the speed gate.
  for (const auto& [aside, verdict] :
       {std::pair{0.16, Verdict::Outlier}, std::pair{0.14, Verdict::Accepted}}) {
    OdometryBuffer buffer = driving();
    EXPECT_EQ(buffer.add(101.02, {0.51, aside, 0}), verdict);
  }
  OdometryBuffer buffer = driving();
  EXPECT_EQ(buffer.add(101.02, {0.51, 0, 0.31}), Verdict::Outlier);
}

TEST(OdometryBuffer, AGlitchLeavesTheTrackAsItWas) {
  OdometryBuffer buffer = driving();
  EXPECT_EQ(buffer.add(101.02, {9.0, 0, 0}), Verdict::Outlier);
  EXPECT_EQ(buffer.add(101.04, {0.52, 0, 0}), Verdict::Accepted);
  SE2 pose;
  ASSERT_EQ(buffer.at(101.02, pose), PoseAnswer::Known);
  EXPECT_NEAR(pose.x, 0.51, 1e-12) << "interpolated past the glitch";
  EXPECT_EQ(buffer.at(100.5, pose), PoseAnswer::Known) << "history is still there";
}

TEST(OdometryBuffer, TwoMessagesThatAgreeOnAJumpStartAnewFromBoth) {
  OdometryBuffer buffer = driving();
  EXPECT_EQ(buffer.add(101.02, {9.0, 0, 0}), Verdict::Outlier);
  EXPECT_EQ(buffer.add(101.04, {-9.0, 0, 0}), Verdict::Outlier) << "two glitches do not agree";
  EXPECT_EQ(buffer.add(101.06, {-8.99, 0, 0}), Verdict::PoseJump);
  SE2 pose;
  EXPECT_EQ(buffer.at(100.5, pose), PoseAnswer::TooOld) << "what was before is gone";
  ASSERT_EQ(buffer.at(101.05, pose), PoseAnswer::Known);
  EXPECT_NEAR(pose.x, -8.995, 1e-12);
  EXPECT_EQ(buffer.add(101.08, {-8.98, 0, 0}), Verdict::Accepted);
}

TEST(OdometryBuffer, NoiseOfMessagesThatNearlyCoincideIsNoJump) {
  OdometryBuffer buffer;
  buffer.add(10.0, {});
  EXPECT_EQ(buffer.add(10.0 + 1e-6, {0.001, 0.0, 0.0}), Verdict::Accepted);
}

TEST(OdometryBuffer, ForgetsWhatIsOlderThanItsLength) {
  OdometryParameters parameters;
  parameters.buffer = 1.0;
  OdometryBuffer buffer(parameters);
  for (int i = 0; i <= 300; ++i) buffer.add(0.01 * i, {});
  SE2 pose;
  EXPECT_EQ(buffer.at(1.98, pose), PoseAnswer::TooOld);
  EXPECT_EQ(buffer.at(2.01, pose), PoseAnswer::Known);
  buffer.clear();
  EXPECT_TRUE(buffer.empty());
  EXPECT_FALSE(buffer.newest());
}

TEST(OdometryBuffer, VerdictsHaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const Verdict verdict :
       {Verdict::Accepted, Verdict::NotFinite, Verdict::Duplicate, Verdict::OutOfOrder,
        Verdict::TimeJump, Verdict::Outlier, Verdict::PoseJump}) {
    names.insert(name(verdict));
    EXPECT_EQ(startsAnew(verdict), verdict == Verdict::TimeJump || verdict == Verdict::PoseJump);
  }
  EXPECT_EQ(names.size(), 7U);
}

}  // namespace
}  // namespace ipm_mapping
