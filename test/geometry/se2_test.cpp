#include "ipm_mapping/geometry/se2.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>

namespace ipm_mapping {
namespace {

class Se2Test : public ::testing::Test {
 protected:
  SE2 randomPose() {
    return {8.0 * unit_(random_) - 4.0, 8.0 * unit_(random_) - 4.0, 6.28 * unit_(random_) - 3.14};
  }
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> unit_{0.0, 1.0};
};

void expectSame(const SE2& a, const SE2& b) {
  EXPECT_NEAR(a.x, b.x, 1e-12);
  EXPECT_NEAR(a.y, b.y, 1e-12);
  EXPECT_NEAR(wrapAngle(a.theta - b.theta), 0.0, 1e-12);
}

TEST_F(Se2Test, IsAGroup) {
  for (int i = 0; i < 200; ++i) {
    const SE2 a = randomPose(), b = randomPose(), c = randomPose();
    expectSame((a * b) * c, a * (b * c));
    expectSame(a * SE2{}, a);
    expectSame(SE2{} * a, a);
    expectSame(a * a.inverse(), SE2{});
    expectSame(a.inverse() * a, SE2{});
    expectSame((a * b).inverse(), b.inverse() * a.inverse());
  }
}

TEST_F(Se2Test, ExponentialIsManySmallStepsAndLogarithmItsInverse) {
  for (int i = 0; i < 50; ++i) {
    const SE2 pose = randomPose();
    const Eigen::Vector3d v = logarithm(pose);
    expectSame(exponential(v), pose);
    SE2 walked;
    constexpr int steps = 20000;
    for (int k = 0; k < steps; ++k) walked = walked * SE2{v[0] / steps, v[1] / steps, v[2] / steps};
    EXPECT_NEAR(walked.x, pose.x, 2e-3);
    EXPECT_NEAR(walked.y, pose.y, 2e-3);
  }
  for (const double theta : {0.0, 1e-9, -1e-7, 1e-6, 2e-6}) {
    const SE2 straight{0.3, -0.2, theta};
    expectSame(exponential(logarithm(straight)), straight);
  }
}

TEST_F(Se2Test, ActsOnPointsAsItsMatrixDoes) {
  for (int i = 0; i < 200; ++i) {
    const SE2 a = randomPose(), b = randomPose();
    const Eigen::Vector2d p = randomPose().translation();
    EXPECT_TRUE((a * p).isApprox((a.matrix() * p.homogeneous()).head<2>(), 1e-12));
    EXPECT_TRUE((a * (b * p)).isApprox((a * b) * p, 1e-12));
    EXPECT_TRUE((a * b).matrix().isApprox(a.matrix() * b.matrix(), 1e-12));
    EXPECT_TRUE(a.inverse().matrix().isApprox(a.matrix().inverse(), 1e-12));
  }
}

TEST_F(Se2Test, TurnsLeftForPositiveAngles) {
  const Eigen::Vector2d p = SE2{1.0, 2.0, M_PI / 2.0} * Eigen::Vector2d(3.0, 0.0);
  EXPECT_NEAR(p.x(), 1.0, 1e-12);
  EXPECT_NEAR(p.y(), 5.0, 1e-12);
}

TEST_F(Se2Test, WrapsAngles) {
  EXPECT_NEAR(wrapAngle(3.0 * M_PI / 2.0), -M_PI / 2.0, 1e-12);
  EXPECT_NEAR(wrapAngle(-3.0 * M_PI / 2.0), M_PI / 2.0, 1e-12);
  EXPECT_NEAR(wrapAngle(200.0 * M_PI + 0.25), 0.25, 1e-9);
  EXPECT_NEAR(std::abs(wrapAngle(M_PI)), M_PI, 1e-12);
  EXPECT_NEAR((SE2{0, 0, 3.0} * SE2{0, 0, 3.0}).theta, 6.0 - 2.0 * M_PI, 1e-12);
}

TEST_F(Se2Test, InterpolatesTheShortWayRound) {
  const SE2 a{0.0, 0.0, 3.0}, b{1.0, 2.0, -3.0};
  const SE2 quarter = interpolate(a, b, 0.25);
  EXPECT_NEAR(quarter.x, 0.25, 1e-12);
  EXPECT_NEAR(quarter.y, 0.5, 1e-12);
  EXPECT_NEAR(quarter.theta, 3.0 + 0.25 * (2.0 * M_PI - 6.0), 1e-12);
  const SE2 most = interpolate(a, b, 0.75);
  EXPECT_NEAR(most.theta, -3.0 - 0.25 * (2.0 * M_PI - 6.0), 1e-12);
  expectSame(interpolate(a, b, 0.0), a);
  expectSame(interpolate(a, b, 1.0), b);
}

TEST_F(Se2Test, IsFiniteOnlyWhenAllOfItIs) {
  const double bad[] = {std::nan(""), INFINITY, -INFINITY};
  EXPECT_TRUE((SE2{1, 2, 3}.finite()));
  for (const double value : bad) {
    EXPECT_FALSE((SE2{value, 0, 0}.finite()));
    EXPECT_FALSE((SE2{0, value, 0}.finite()));
    EXPECT_FALSE((SE2{0, 0, value}.finite()));
  }
}

}  // namespace
}  // namespace ipm_mapping
