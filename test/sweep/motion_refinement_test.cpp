#include "ipm_mapping/sweep/motion_refinement.hpp"

#include <gtest/gtest.h>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

/// Two views of a textured floor with a box in it, the true motion between them known.
class Refinement : public ::testing::Test {
 protected:
  void SetUp() override {
    scene.boxes = {{1.3, 1.6, 0.25, 0.6, 0.4}};
    grid = makePolarGrid(scene.camera, scene.T_base_camera, parameters.grid, 2.0);
    rectification.configure(scene.camera, scene.T_base_camera, grid);
    lattice.configure(grid, rectification.ranges());
    current = rectified(T_odom_now);
    reference = rectified(SE2{});
  }
  RectifiedFrame rectified(const SE2& pose, const Sway& sway = {}) {
    RectifiedFrame frame;
    frame.image.resize(grid.rows, grid.lines);
    const Image<std::uint8_t> raw = scene.render(pose, sway);
    rectification.rectify(raw.view(), frame.image.view());
    frame.mean.evaluate(lattice, frame.image.view());
    return frame;
  }
  RefinedMotion refine(const SE2& odometry) { return refine(odometry, odometry); }
  RefinedMotion refine(const SE2& odometry, const SE2& start) {
    MotionRefinement refinement;
    refinement.configure(grid, rectification.ranges(), scene.T_base_camera.translation().head<2>(),
                         parameters.refinement);
    return refinement.refine(current, reference, odometry, start);
  }
  SweepParameters parameters = test::smallParameters();
  test::GrainedScene scene{test::smallCamera(), test::smallCameraPose()};
  const SE2 T_odom_now{0.15, 0.004, 0.03};
  PolarGrid grid;
  CylindricalRectification rectification;
  BlockLattice lattice;
  RectifiedFrame current, reference;
};

TEST_F(Refinement, RemovesMostOfAnOdometryError) {
  const RefinedMotion refined = refine({0.1535, 0.004, 0.032});
  ASSERT_TRUE(refined.refined);
  EXPECT_NEAR(refined.motion.x, T_odom_now.x, 0.0008);
  EXPECT_NEAR(refined.motion.y, T_odom_now.y, 0.0008);
  EXPECT_NEAR(refined.motion.theta, T_odom_now.theta, 0.0008);
}

/// A heading that went wrong at a constant rate has carried the odometry sideways as well.
TEST_F(Refinement, RemovesABiasOfTheHeadingRate) {
  current.went = 1.0;
  const double wrong = 0.012;
  const RefinedMotion refined =
      refine({0.15, 0.004 + 0.5 * 0.15 * wrong, T_odom_now.theta + wrong});
  EXPECT_NEAR(refined.motion.x, T_odom_now.x, 0.0013);
  EXPECT_NEAR(refined.motion.y, T_odom_now.y, 0.0013);
  EXPECT_NEAR(refined.motion.theta, T_odom_now.theta, 0.0013);
}

/// The wheels have turned for a third more than was driven; what was refined so far is nearer.
TEST_F(Refinement, SlippingWheelsAreNotBelieved) {
  const RefinedMotion refined = refine({0.20, 0.004, 0.03}, {0.162, 0.004, 0.03});
  EXPECT_NEAR(refined.motion.x, T_odom_now.x, 0.0013);
  EXPECT_NEAR(refined.motion.theta, T_odom_now.theta, 0.0013);
}

TEST_F(Refinement, KeepsATrueMotion) {
  const RefinedMotion refined = refine(T_odom_now);
  EXPECT_NEAR(refined.motion.x, T_odom_now.x, 0.0005);
  EXPECT_NEAR(refined.motion.theta, T_odom_now.theta, 0.001);
}

TEST_F(Refinement, KnowsAStillRobot) {
  const RefinedMotion refined = refine(T_odom_now);
  EXPECT_LT(refined.sway.size(), 0.0003);
}

/// Half a pixel of nod is worth four millimetres of way in the near field, and more far away.
TEST_F(Refinement, TellsANodFromAMotion) {
  for (const Sway sway :
       {Sway{0.004, 0.0}, Sway{-0.004, 0.0}, Sway{0.0, 0.004}, Sway{0.003, -0.002}}) {
    reference = rectified(SE2{}, sway);
    const RefinedMotion refined = refine({0.1515, 0.004, 0.031});
    ASSERT_TRUE(refined.refined);
    EXPECT_NEAR(refined.sway.pitch, sway.pitch, 0.0004) << sway.pitch << ' ' << sway.roll;
    EXPECT_NEAR(refined.sway.roll, sway.roll, 0.001) << sway.pitch << ' ' << sway.roll;
    EXPECT_NEAR(refined.motion.x, T_odom_now.x, 0.0013);
    EXPECT_NEAR(refined.motion.y, T_odom_now.y, 0.0008);
    EXPECT_NEAR(refined.motion.theta, T_odom_now.theta, 0.001);
  }
}

/// What is taken for the current frame's attitude is that of the current frame.
TEST_F(Refinement, TheSwayIsTheReferencesAgainstTheCurrentFrame) {
  const Sway sway{0.003, 0.002};
  current = rectified(T_odom_now, sway);
  const RefinedMotion refined = refine(T_odom_now);
  EXPECT_NEAR(refined.sway.pitch, -sway.pitch, 0.0004);
  EXPECT_NEAR(refined.sway.roll, -sway.roll, 0.001);
}

TEST_F(Refinement, CovarianceIsPositiveAndTighterThanThePrior) {
  const RefinedMotion refined = refine({0.1535, 0.004, 0.032});
  const double prior =
      parameters.refinement.sd_forward * 0.1535 + parameters.refinement.sd_forward_floor;
  EXPECT_GT(refined.covariance.determinant(), 0.0);
  EXPECT_LT(refined.covariance(0, 0), 0.25 * prior * prior);
}

TEST_F(Refinement, OffTrustsOdometryButStillFitsBrightness) {
  parameters.refinement.refine = false;
  for (int line = 0; line < grid.lines; ++line)
    for (int row = 0; row < grid.rows; ++row)
      current.image.at(row, line) =
          static_cast<std::uint8_t>(std::lround(0.9 * current.image.at(row, line) + 6.0));
  const RefinedMotion refined = refine(T_odom_now);
  EXPECT_FALSE(refined.refined);
  EXPECT_DOUBLE_EQ(refined.motion.x, T_odom_now.x);
  EXPECT_NEAR(refined.photometric.gain * 80 + refined.photometric.offset, 0.9 * 80 + 6, 2.0);
}

/// A lamp that is switched, or automatic exposure: far more than what is an outlier.
TEST_F(Refinement, FollowsBrightnessThatChangesByFar) {
  const RectifiedFrame before = current;
  for (const double gain : {0.55, 0.75, 1.35}) {
    for (int line = 0; line < grid.lines; ++line)
      for (int row = 0; row < grid.rows; ++row)
        current.image.at(row, line) = static_cast<std::uint8_t>(
            std::min(255.0, std::lround(gain * before.image.at(row, line)) * 1.0));
    current.mean.evaluate(lattice, current.image.view());
    const RefinedMotion refined = refine(T_odom_now);
    const Photometric& p = refined.photometric;
    EXPECT_NEAR(p.gain * 120.0 + p.offset, gain * 120.0, 3.0) << gain;
    EXPECT_LT(refined.sigma, 3.0) << gain;
    EXPECT_NEAR(refined.motion.x, T_odom_now.x, 0.001) << gain;
  }
}

/// Somebody who covers a part of the floor is no change of the light.
TEST_F(Refinement, WhatCoversTheFloorDoesNotChangeItsBrightness) {
  const RectifiedFrame before = current;
  for (const double dark : {0.5, 0.6, 0.7, 0.8}) {
    current = before;
    for (int line = 0; line < grid.lines * 49 / 100; ++line)
      for (int row = 0; row < grid.rows; ++row)
        current.image.at(row, line) =
            static_cast<std::uint8_t>(std::lround(dark * before.image.at(row, line)));
    current.mean.evaluate(lattice, current.image.view());
    const Photometric p = refine(T_odom_now).photometric;
    EXPECT_NEAR(p.gain * 120.0 + p.offset, 120.0, 4.0) << dark;
  }
}

TEST_F(Refinement, WithoutFloorInCommonOdometryStays) {
  const SE2 elsewhere{0.15, 0.0, 2.5};
  const RefinedMotion refined = refine(elsewhere, {0.1, 0.0, 2.4});
  EXPECT_FALSE(refined.refined);
  EXPECT_DOUBLE_EQ(refined.motion.theta, elsewhere.theta);
}

TEST_F(Refinement, FloorBehindAContactDoesNotTakePart) {
  MotionRefinement refinement;
  refinement.configure(grid, rectification.ranges(), scene.T_base_camera.translation().head<2>(),
                       parameters.refinement);
  const int all = refinement.refine(current, reference, T_odom_now, T_odom_now).samples;
  const int half_way = static_cast<int>(grid.row(0.8));
  for (int line = 0; line < grid.lines; ++line) refinement.setFloorBegin(line, half_way);
  const int near = refinement.refine(current, reference, T_odom_now, T_odom_now).samples;
  EXPECT_LT(near, all - 100);
  refinement.forgetFloor();
  EXPECT_EQ(refinement.refine(current, reference, T_odom_now, T_odom_now).samples, all);
}

}  // namespace
}  // namespace ipm_mapping::sweep
