#include "ipm_mapping/sweep/floor_warp.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

using I = CalibrationIndex;

CalibrationVector wrongBy(double pitch, double roll, double yaw, double log_height) {
  CalibrationVector state = CalibrationVector::Zero();
  state[I::Pitch] = pitch;
  state[I::Roll] = roll;
  state[I::Yaw] = yaw;
  state[I::LogHeight] = log_height;
  return state;
}

/// A camera that looks to the left, so that its axes are not those of base.
CameraPose statedPose() { return cameraPose(0.07, -0.03, 0.45, 0.42, 0.4); }

PolarGrid gridOf(const CameraPose& pose) {
  return makePolarGrid(test::smallCamera(), pose, test::smallParameters().grid, 2.0);
}

/// Row and line at which a camera sees a floor point of its base: the long way, through matrices.
Eigen::Vector2d seen(const PolarGrid& grid, const CameraPose& T_base_rectified,
                     const CameraPose& T_base_true, const Eigen::Vector2d& p_base) {
  const Eigen::Vector3d p(p_base.x(), p_base.y(), 0.0);
  const Eigen::Vector3d ray = T_base_rectified.linear() * (T_base_true.inverse() * p);
  return {(std::log(-ray.z() / ray.head<2>().norm()) - grid.log_r_far) * grid.rows_per_log,
          grid.line(std::atan2(ray.y(), ray.x()))};
}

TEST(CalibrationState, PitchAndHeightOfTheCorrectedPoseAreThoseOfTheState) {
  const CameraPose pose = corrected(statedPose(), wrongBy(0.02, 0.0, 0.0, 0.05));
  EXPECT_NEAR(pitchOf(pose), 0.44, 1e-9);
  EXPECT_NEAR(pose.translation().z(), 0.45 * std::exp(0.05), 1e-9);
  EXPECT_TRUE(pose.isApprox(cameraPose(0.07, -0.03, 0.45 * std::exp(0.05), 0.44, 0.4), 1e-9));
}

TEST(CalibrationState, RollAndYawTurnTheWayTheyAreNamed) {
  // Positive roll lifts the left side, positive yaw looks further to the left.
  const CameraPose rolled = corrected(cameraPose(0, 0, 1, 0.0), wrongBy(0.0, 0.1, 0.0, 0.0));
  EXPECT_NEAR(rolled.linear()(2, 0), -std::sin(0.1), 1e-9);
  const CameraPose turned = corrected(cameraPose(0, 0, 1, 0.3), wrongBy(0.0, 0.0, 0.1, 0.0));
  EXPECT_TRUE(turned.isApprox(cameraPose(0, 0, 1, 0.3, 0.1), 1e-9));
}

TEST(CalibrationState, OdometryIsCorrectedAlongTheArc) {
  CalibrationVector state = CalibrationVector::Zero();
  state[I::LogScale] = 0.01;
  state[I::TurnScale] = 0.1;
  state[I::YawRate] = 0.02;
  // A true arc of radius 2 m over 0.3 rad; odometry says what makes the corrections true.
  const double turn = 0.3, seconds = 1.5, radius = 2.0;
  const double said = (turn - 0.02 * seconds) / 1.1;
  const auto chord = [](double r, double angle) {
    return SE2{r * std::sin(angle), r * (1.0 - std::cos(angle)), angle};
  };
  const double way = radius * turn;
  const SE2 odometry = chord(way * std::exp(-0.01) / said, said);
  const SE2 truth = chord(radius, turn), result = corrected(odometry, seconds, state);
  EXPECT_NEAR(result.x, truth.x, 1e-3);
  EXPECT_NEAR(result.y, truth.y, 1e-3);
  EXPECT_NEAR(result.theta, truth.theta, 1e-12);
}

TEST(CalibrationState, SlopesOfTheCorrectionAreItsDifferences) {
  const SE2 odometry{0.3, 0.02, 0.2};
  CalibrationVector state = CalibrationVector::Zero();
  state.segment<3>(I::LogScale) << 0.02, -0.03, 0.01;
  const Eigen::Matrix3d slopes = correctionSlopes(odometry, 1.2, state);
  for (int k = 0; k < 3; ++k) {
    CalibrationVector more = state, less = state;
    more[I::LogScale + k] += 1e-6;
    less[I::LogScale + k] -= 1e-6;
    const SE2 a = corrected(odometry, 1.2, more), b = corrected(odometry, 1.2, less);
    const Eigen::Vector3d difference(a.x - b.x, a.y - b.y, a.theta - b.theta);
    EXPECT_LT((difference / 2e-6 - slopes.col(k)).norm(), 1e-6) << k;
  }
}

/// Where a pixel's floor point is seen from the other place, through matrices and through the warp.
TEST(FloorWarp, SeesWhatTheTrueCameraSees) {
  const CameraPose stated = statedPose();
  const StatedCamera camera(stated);
  const CalibrationVector state = wrongBy(0.02, -0.01, 0.008, 0.06);
  const CalibrationVector in_force = wrongBy(0.012, 0.002, -0.004, 0.03);
  const CameraPose T_base_true = corrected(stated, state);
  const CameraPose T_base_rectified = corrected(stated, in_force);
  const PolarGrid grid = gridOf(T_base_rectified);
  const SE2 motion{0.2, 0.01, 0.1};
  const FloorWarp warp(grid, camera, state, in_force, motion);
  for (const Eigen::Vector2d& p_base : {Eigen::Vector2d(1.0, 0.5), Eigen::Vector2d(1.8, 1.2)}) {
    const Eigen::Vector2d here = seen(grid, T_base_rectified, T_base_true, p_base);
    const Eigen::Vector2d there = seen(grid, T_base_rectified, T_base_true, motion * p_base);
    FloorWarp::Position at;
    ASSERT_TRUE(warp(statedDirection(grid, camera, in_force, here.x(), here.y()), at));
    EXPECT_NEAR(at.row, there.x(), 1e-6);
    EXPECT_NEAR(at.line, there.y(), 1e-6);
  }
}

/// Both rows are read while the robot goes on: where the camera is then, through matrices.
TEST(FloorWarp, SeesWhatARollingShutterSees) {
  const CameraPose stated = statedPose();
  const StatedCamera camera(stated);
  const PolarGrid grid = gridOf(stated);
  const CalibrationVector zero = CalibrationVector::Zero();
  const SE2 motion{0.2, -0.25, 0.1};
  const ReadoutOfPair readout{{0.3, 0.02, 0.7}, {0.25, 0.0, -0.4}, 0.03, 0.02};
  const ReadTimes times{0.35, -0.2};
  const FloorWarp warp(grid, camera, zero, zero, motion, Eigen::Vector2d::Zero(), readout);
  const auto after = [](const Velocity& v, double t) { return SE2{v.x * t, v.y * t, v.theta * t}; };
  const SE2 gone_current = after(readout.current, times.current * readout.current_seconds);
  const SE2 gone_reference = after(readout.reference, times.reference * readout.reference_seconds);
  for (const Eigen::Vector2d& p_base : {Eigen::Vector2d(1.0, 0.5), Eigen::Vector2d(1.8, 1.2)}) {
    const Eigen::Vector2d here = seen(grid, stated, stated, gone_current.inverse() * p_base);
    const Eigen::Vector2d there =
        seen(grid, stated, stated, gone_reference.inverse() * (motion * p_base));
    FloorWarp::Position at;
    ASSERT_TRUE(warp(statedDirection(grid, camera, zero, here.x(), here.y()), at, times));
    EXPECT_NEAR(at.row, there.x(), 0.02);
    EXPECT_NEAR(at.line, there.y(), 0.02);
    FloorWarp::Position at_once;
    ASSERT_TRUE(warp(statedDirection(grid, camera, zero, here.x(), here.y()), at_once));
    EXPECT_GT(std::hypot(at_once.row - there.x(), at_once.line - there.y()), 0.5);
  }
}

/// The poses go on, each in its own time; the motion between them is what it says.
TEST(MovingPair, MovesAsItsTwoPosesDo) {
  const SE2 reference{1.0, -2.0, 0.8}, current{1.3, -1.9, 1.2};
  const Velocity vr{0.25, -0.03, -0.4}, vc{0.3, 0.02, 0.7};
  const MovingPair pair(reference.inverse() * current, vc, vr);
  for (const auto& [tc, tr] : {std::pair(1e-4, 0.0), {0.0, 1e-4}, {2e-4, -1e-4}}) {
    const SE2 motion = later(reference, vr, tr).inverse() * later(current, vc, tc);
    const SE2 before = reference.inverse() * current;
    const Eigen::Vector3d d = pair.after(tc, tr);
    EXPECT_NEAR(motion.x - before.x, d.x(), 1e-8);
    EXPECT_NEAR(motion.y - before.y, d.y(), 1e-8);
    EXPECT_NEAR(motion.theta - before.theta, d.z(), 1e-12);
  }
}

TEST(FloorWarp, RefusesWhatDoesNotMeetTheFloor) {
  const PolarGrid grid = gridOf(statedPose());
  const StatedCamera camera(statedPose());
  const FloorWarp warp(grid, camera, CalibrationVector::Zero(), CalibrationVector::Zero(), {});
  FloorWarp::Position at;
  EXPECT_FALSE(warp({1.0, 0.0, 0.0}, at));
  EXPECT_FALSE(warp({1.0, 0.0, 0.3}, at));
  EXPECT_TRUE(warp({1.0, 0.0, -0.3}, at));
}

TEST(FloorWarp, SlopesAreItsDifferences) {
  const StatedCamera camera(statedPose());
  const PolarGrid grid = gridOf(statedPose());
  const CalibrationVector state = wrongBy(0.02, -0.01, 0.008, 0.06);
  const CalibrationVector in_force = wrongBy(0.01, 0.0, 0.0, 0.0);
  const auto at = [&](const Eigen::Matrix<double, FloorWarp::count, 1>& step, double row,
                      double line, FloorWarp::Position& position) {
    CalibrationVector moved = state;
    moved.head<4>() += step.head<4>();
    const SE2 motion{0.2 + step[FloorWarp::X], 0.01 + step[FloorWarp::Y],
                     0.1 + step[FloorWarp::Theta]};
    const double readout = 0.02 + step[FloorWarp::ReadoutTime];
    const FloorWarp warp(grid, camera, moved, in_force, motion,
                         step.segment<2>(FloorWarp::SwayPitch),
                         {{0.3, 0.02, 0.7}, {0.25, 0.0, -0.4}, readout, readout});
    EXPECT_TRUE(warp(statedDirection(grid, camera, in_force, row, line), position, {0.35, -0.2}));
    return warp.slopes(position);
  };
  using Step = Eigen::Matrix<double, FloorWarp::count, 1>;
  for (const double row : {40.0, 160.0}) {
    for (const double line : {30.0, 200.0}) {
      FloorWarp::Position here, more, less;
      const FloorWarp::Slopes slopes = at(Step::Zero(), row, line, here);
      for (int k = 0; k < FloorWarp::count; ++k) {
        constexpr double step = 1e-5;
        at(step * Step::Unit(k), row, line, more);
        at(-step * Step::Unit(k), row, line, less);
        const double scale = 1.0 + slopes.col(k).norm();
        EXPECT_NEAR((more.row - less.row) / (2 * step), slopes(0, k), 3e-3 * scale) << k;
        EXPECT_NEAR((more.line - less.line) / (2 * step), slopes(1, k), 3e-3 * scale) << k;
      }
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::sweep
