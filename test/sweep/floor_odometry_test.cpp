#include "ipm_mapping/sweep/floor_odometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace ipm_mapping::sweep {
namespace {

constexpr int window = 5;  // frames from a reference to the frame that uses it
constexpr double period = 0.1, step = 0.03;

/// A drive, what the wheels make of it, and what the floor shows.
struct Drive {
  std::vector<SE2> truth, wheels;
  Eigen::Vector3d floor_sd = Eigen::Vector3d::Zero();
  std::mt19937 random{7};

  /// Equal arcs of `turn` radians; wheels see `scale` times the way and `turn_bias` more.
  Drive(int frames, double turn, double scale, double turn_bias, const SE2& start = {}) {
    truth = wheels = {start};
    for (int k = 1; k < frames; ++k) {
      truth.push_back(truth.back() * exponential({step, 0.0, turn}));
      wheels.push_back(wheels.back() * exponential({scale * step, 0.0, turn + turn_bias}));
    }
  }
  RefinedMotion floor(int from, int to) {
    std::normal_distribution<double> normal;
    const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
    const SE2 delta = truth[a].inverse() * truth[b];
    RefinedMotion motion;
    motion.motion = {delta.x + floor_sd[0] * normal(random), delta.y + floor_sd[1] * normal(random),
                     delta.theta + floor_sd[2] * normal(random)};
    motion.covariance = floor_sd.cwiseAbs2().asDiagonal();
    motion.refined = true;
    motion.reference_stamp = period * from;
    return motion;
  }
};

FloorOdometryParameters constant(double sd_scale, double sd_turn) {
  FloorOdometryParameters parameters;
  parameters.sd_scale = sd_scale;
  parameters.sd_turn = sd_turn;
  parameters.sd_shift = 0.0;
  return parameters;
}
FloorOdometryParameters nothingConstant() { return constant(0.0, 0.0); }

/// Every `every`-th frame is used, once there is a frame `window` back; the others are not.
FloorPose follow(Drive& drive, FloorOdometry& odometry, int every = 1) {
  for (int k = 0; k < static_cast<int>(drive.wheels.size()); ++k) {
    const bool used = k >= window && k % every == 0;
    const RefinedMotion motion = used ? drive.floor(k - window, k) : RefinedMotion{};
    odometry.add({period * k, drive.wheels[static_cast<std::size_t>(k)], used ? &motion : nullptr,
                  Kept::Added});
  }
  return odometry.pose();
}

void expectNear(const SE2& a, const SE2& b, double metres, double radians) {
  EXPECT_NEAR(a.x, b.x, metres);
  EXPECT_NEAR(a.y, b.y, metres);
  EXPECT_NEAR(wrapAngle(a.theta - b.theta), 0.0, radians);
}

TEST(FloorOdometry, WithoutFloorItIsWheelOdometry) {
  Drive drive(40, 0.02, 1.05, 0.003, {1.0, -2.0, 0.5});
  FloorOdometry odometry;
  for (std::size_t k = 0; k < drive.wheels.size(); ++k) {
    odometry.add({period * static_cast<double>(k), drive.wheels[k], nullptr, Kept::Added});
    expectNear(odometry.pose().T_odom_base, drive.wheels[k], 1e-12, 1e-12);
  }
}

TEST(FloorOdometry, EveryPieceOfTheWayIsCorrectedOnce) {
  for (const int every : {1, 2, 3, window, window + 3}) {
    Drive straight(61, 0.0, 1.1, 0.0, {1.0, -2.0, 0.5});
    FloorOdometry odometry;
    const int last = 60 - 60 % every;
    straight.truth.resize(static_cast<std::size_t>(last) + 1);
    straight.wheels.resize(static_cast<std::size_t>(last) + 1);
    const FloorPose pose = follow(straight, odometry, every);
    // What no window covers: before the first one, and between windows where few are used.
    const int first = (window + every - 1) / every * every, uses = (last - first) / every + 1;
    const int uncovered = first - window + std::max(0, every - window) * (uses - 1);
    const double wrong = 0.1 * step * uncovered;
    EXPECT_NEAR((straight.truth.back().inverse() * pose.T_odom_base).x, wrong, 1e-9)
        << "used: one frame of " << every;
  }
}

TEST(FloorOdometry, FollowsTheFloorThroughACurveWhenScaleAndHeadingAreWrong) {
  Drive curve(200, 0.012, 1.04, 0.002);
  FloorOdometry odometry;
  const FloorPose pose = follow(curve, odometry);
  const SE2 wheels = curve.truth.back().inverse() * curve.wheels.back();
  ASSERT_GT(wheels.distance(), 0.5);
  expectNear(pose.T_odom_base, curve.truth.back(), 0.02 * wheels.distance(), 1e-3);
}

TEST(FloorOdometry, AfterAStretchOnWheelsTheNextWindowIsCorrectedWhole) {
  Drive drive(60, 0.0, 1.1, 0.0);
  FloorOdometry odometry;
  for (int k = 0; k < 60; ++k) {
    const bool used = k >= window && (k < 20 || k >= 40);
    const RefinedMotion motion = used ? drive.floor(k - window, k) : RefinedMotion{};
    odometry.add({period * k, drive.wheels[static_cast<std::size_t>(k)], used ? &motion : nullptr,
                  Kept::Added});
  }
  const double on_wheels = (40 - window - 19) * step;  // 19 -> 35 nothing was corrected
  EXPECT_NEAR(odometry.pose().T_odom_base.x, 59 * step + 0.1 * on_wheels, 1e-9);
}

/// Stamps that are moved from some frame on move the wheels' pose with them: the robot is there a
/// moment later. Nothing is wrong with odometry for that, and the floor has nothing to correct.
TEST(FloorOdometry, StampsThatAreMovedAreNoErrorOfOdometry) {
  Drive drive(40, 0.01, 1.0, 0.0);
  const Velocity velocity{step / period, 0.0, 0.01 / period};
  constexpr double offset = 0.07;
  FloorOdometry odometry;
  for (int k = 0; k < 40; ++k) {
    const double moved = k < 20 ? 0.0 : offset;
    const bool used = k >= window;
    const RefinedMotion motion = used ? drive.floor(k - window, k) : RefinedMotion{};
    RefinedMotion named = motion;  // after the stamp that its reference came with
    if (k - window >= 20) named.reference_stamp += offset;
    const SE2 wheels = later(drive.wheels[static_cast<std::size_t>(k)], velocity, moved);
    odometry.add(
        {period * k + moved, wheels, used ? &named : nullptr, Kept::Added, velocity, moved});
    expectNear(odometry.pose().T_odom_base, wheels, 1e-9, 1e-9);
  }
}

TEST(FloorOdometry, IgnoresAReferenceThatItDoesNotKnow) {
  Drive drive(12, 0.0, 1.1, 0.0);
  FloorOdometry odometry;
  for (int k = 0; k < 12; ++k) {
    const RefinedMotion motion = drive.floor(std::max(0, k - window), k);
    odometry.add({period * k, drive.wheels[static_cast<std::size_t>(k)], &motion, Kept::No});
  }
  expectNear(odometry.pose().T_odom_base, drive.wheels.back(), 1e-12, 1e-12);
}

TEST(FloorOdometry, TurnsAndMovesWithTheFrameOfTheOdometry) {
  const SE2 moved{3.0, -1.5, 2.0};
  Drive here(80, 0.01, 1.05, 0.001), there(80, 0.01, 1.05, 0.001, moved);
  here.floor_sd = there.floor_sd = {3e-4, 2e-4, 4e-4};
  FloorOdometry a, b;
  const FloorPose p = follow(here, a), q = follow(there, b);
  expectNear(moved * p.T_odom_base, q.T_odom_base, 1e-9, 1e-9);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(moved.theta).toRotationMatrix();
  EXPECT_TRUE((R * p.covariance * R.transpose()).isApprox(q.covariance, 1e-9));
  EXPECT_TRUE(p.velocity.isApprox(q.velocity, 1e-9));
}

/// Covariance that is stated at the end of a drive, and that of the ends of many such drives.
void expectCovarianceOfManyDrives(int frames, double turn, const Eigen::Vector3d& floor_sd) {
  constexpr int runs = 1500;
  Drive drive(frames, turn, 1.05, 0.001);
  drive.floor_sd = floor_sd;
  FloorOdometry odometry(SweepParameters{}, nothingConstant());
  Eigen::Matrix3d measured = Eigen::Matrix3d::Zero();
  for (int run = 0; run < runs; ++run) {
    odometry.reset();
    const FloorPose pose = follow(drive, odometry, window);
    const SE2 &p = pose.T_odom_base, &t = drive.truth.back();
    const Eigen::Vector3d e(p.x - t.x, p.y - t.y, wrapAngle(p.theta - t.theta));
    measured += e * e.transpose() / runs;
  }
  const Eigen::Matrix3d stated = odometry.pose().covariance;
  const Eigen::Vector3d sd = stated.diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(measured(i, i) / stated(i, i), 1.0, 0.15) << i;
    for (int j = 0; j < i; ++j)
      EXPECT_NEAR(measured(i, j) / (sd[i] * sd[j]), stated(i, j) / (sd[i] * sd[j]), 0.12) << i << j;
  }
}

TEST(FloorOdometry, CovarianceIsThatOfManyDrives) {
  expectCovarianceOfManyDrives(20 * window + 1, 0.015, {4e-3, 2e-3, 3e-3});
}

TEST(FloorOdometry, CovarianceIsThatOfManyDrivesWhenWindowsTurnFar) {
  expectCovarianceOfManyDrives(2 * window + 1, 0.06, {6e-3, 1e-3, 1e-4});
}

TEST(FloorOdometry, OverlappingWindowsAreWorthOneWindow) {
  Drive drive(20 * window + 1, 0.0, 1.0, 0.0);
  drive.floor_sd = {4e-3, 2e-3, 3e-3};
  FloorOdometry dense(SweepParameters{}, nothingConstant());
  FloorOdometry sparse(SweepParameters{}, nothingConstant());
  const Eigen::Matrix3d many = follow(drive, dense, 1).covariance;
  const Eigen::Matrix3d few = follow(drive, sparse, window).covariance;
  EXPECT_NEAR(many(0, 0) / few(0, 0), 1.0, 0.05);
  EXPECT_NEAR(many(1, 1) / few(1, 1), 1.0, 0.15);
  EXPECT_NEAR(many(2, 2) / few(2, 2), 1.0, 0.05);
}

TEST(FloorOdometry, ConstantErrorsOfScaleAndHeadingAddUp) {
  Drive drive(100, 0.012, 1.0, 0.0);
  const auto covariance = [&](const FloorOdometryParameters& parameters) {
    FloorOdometry odometry(SweepParameters{}, parameters);
    return Eigen::Matrix3d(follow(drive, odometry).covariance);
  };
  const auto end = [](double scale, double turn_per_metre) {
    const SE2 p = Drive(100, 0.012, scale, turn_per_metre * step).wheels.back();
    return Eigen::Vector3d(p.x, p.y, p.theta);
  };
  constexpr double sd = 1e-4;
  const Eigen::Matrix3d none = covariance(nothingConstant());
  const Eigen::Vector3d by_scale = end(1.0 + sd, 0.0) - end(1.0, 0.0);
  const Eigen::Vector3d by_turn = end(1.0, sd) - end(1.0, 0.0);
  EXPECT_TRUE(
      (covariance(constant(sd, 0.0)) - none).isApprox(by_scale * by_scale.transpose(), 0.01));
  EXPECT_TRUE((covariance(constant(0.0, sd)) - none).isApprox(by_turn * by_turn.transpose(), 0.01));
}

TEST(FloorOdometry, StandingCostsNothingAndTurningOnTheSpotCostsHeading) {
  Drive drive(40, 0.0, 1.0, 0.0);
  drive.floor_sd = {3e-4, 2e-4, 4e-4};
  FloorOdometry odometry;
  const FloorPose before = follow(drive, odometry);
  SE2 pose = drive.wheels.back();
  for (int k = 40; k < 300; ++k) odometry.add({period * k, pose, nullptr, Kept::No});
  EXPECT_TRUE(odometry.pose().covariance.isApprox(before.covariance, 1e-12));
  EXPECT_LT(odometry.pose().velocity.norm(), 1e-12);
  for (int k = 300; k < 310; ++k) {
    pose.theta += 0.1;
    odometry.add({period * k, pose, nullptr, Kept::No});
  }
  const MotionRefinementParameters wheels;
  const double added = wheels.sd_turn_share * 1.0 + wheels.sd_turn_rate * 1.0;
  EXPECT_NEAR(odometry.pose().covariance(2, 2) - before.covariance(2, 2), added * added, 1e-9);
  EXPECT_NEAR(odometry.pose().velocity.z(), 1.0, 1e-9);
}

TEST(FloorOdometry, VelocityIsTheFloorsNotTheWheels) {
  Drive drive(40, 0.012, 1.1, 0.003);
  drive.floor_sd = {1e-6, 1e-6, 1e-6};
  FloorOdometry odometry;
  const FloorPose& first = odometry.add({-period, drive.wheels.front(), nullptr, Kept::No});
  EXPECT_GT(first.velocity_covariance(0, 0), 1e3) << "one frame says nothing";
  const FloorPose pose = follow(drive, odometry);
  EXPECT_NEAR(pose.velocity.x(), step / period, 0.002 * step / period);
  EXPECT_NEAR(pose.velocity.z(), 0.012 / period, 0.002);
  EXPECT_GT(pose.velocity_covariance.determinant(), 0.0);
  EXPECT_LT(pose.velocity_covariance(0, 0), 1e-4);
}

/// A window that reaches back over a stop: the wheels went wrong only while they moved.
TEST(FloorOdometry, VelocityAfterAStopIsTheFloorsAsWell) {
  Drive drive(42, 0.0, 1.1, 0.0);
  drive.floor_sd = {1e-6, 1e-6, 1e-6};
  FloorOdometry odometry;
  for (int k = 0; k < 42; ++k) {
    for (int still = 0; k == 40 && still < 100; ++still)
      odometry.add({period * (k + still), drive.wheels[39], nullptr, Kept::No});
    const double clock = period * (k < 40 ? k : k + 100);
    const RefinedMotion motion = k >= window ? drive.floor(k - window, k) : RefinedMotion{};
    odometry.add({clock, drive.wheels[static_cast<std::size_t>(k)], k >= window ? &motion : nullptr,
                  Kept::Added});
  }
  EXPECT_NEAR(odometry.pose().velocity.x(), step / period, 0.002 * step / period);
}

/// Of a robot that turns on the spot the latest view takes the place of the one before.
TEST(FloorOdometry, LooksAroundAndKnowsItsReferences) {
  SweepParameters few;
  few.reference.history = 8;
  Drive drive(12, 0.0, 1.1, 0.0);
  for (const Kept kept : {Kept::InPlaceOfNewest, Kept::Added}) {
    FloorOdometry odometry(few, {});
    for (int k = 0; k < 11; ++k)
      odometry.add({period * k, drive.wheels[static_cast<std::size_t>(k)], nullptr, Kept::Added});
    for (int k = 0; k < 20; ++k)
      odometry.add(
          {2.0 + period * k, drive.wheels[10] * SE2{0.0, 0.0, 0.05 * (k % 10)}, nullptr, kept});
    const RefinedMotion motion = drive.floor(11 - window, 11);
    const double wheels = drive.wheels[11].x;
    odometry.add({5.0, drive.wheels[11], &motion, Kept::Added});
    const bool corrected = odometry.pose().T_odom_base.x < wheels - 0.05 * step;
    EXPECT_EQ(corrected, kept == Kept::InPlaceOfNewest);
  }
}

TEST(FloorOdometry, AfterAResetItStartsWhereTheWheelsAre) {
  Drive drive(40, 0.0, 1.1, 0.0);
  FloorOdometry odometry;
  follow(drive, odometry);
  odometry.reset();
  const SE2 elsewhere{5.0, 6.0, 1.0};
  const RefinedMotion motion = drive.floor(30, 36);  // a reference of before
  odometry.add({3.6, elsewhere, &motion, Kept::Added});
  expectNear(odometry.pose().T_odom_base, elsewhere, 1e-12, 1e-12);
  EXPECT_EQ(odometry.pose().covariance.norm(), 0.0);
}

TEST(FloorOdometry, NewParametersLeaveThePose) {
  Drive drive(40, 0.0, 1.1, 0.0);
  FloorOdometry odometry;
  const SE2 before = follow(drive, odometry).T_odom_base;
  SweepParameters changed;
  changed.reference.history = 10;
  odometry.configure(changed, {});
  odometry.add({period * 40, drive.wheels.back() * SE2{0.05, 0.0, 0.0}, nullptr, Kept::Added});
  expectNear(odometry.pose().T_odom_base, before * SE2{0.05, 0.0, 0.0}, 1e-12, 1e-12);
}

}  // namespace
}  // namespace ipm_mapping::sweep
