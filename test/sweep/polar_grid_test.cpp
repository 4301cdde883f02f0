#include "ipm_mapping/sweep/polar_grid.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/sweep/foot_motion.hpp"
#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

using test::smallCamera;
using test::smallCameraPose;

TEST(PolarGrid, RowsAndDistancesAreInverses) {
  const PolarGrid grid = makePolarGrid(smallCamera(), smallCameraPose(), {}, 2.0);
  for (double row = 0.0; row < grid.rows; row += 7.3) {
    EXPECT_NEAR(grid.row(grid.distance(row)), row, 1e-9);
    EXPECT_NEAR(grid.line(grid.azimuth(row)), row, 1e-9);
  }
}

TEST(PolarGrid, CoversEveryFloorPixelOfTheImageWithinRange) {
  const CameraModel camera = smallCamera();
  const CameraPose pose = smallCameraPose();
  const PolarGrid grid = makePolarGrid(camera, pose, {}, 2.0);
  const GroundProjection floor(groundHomography(camera.intrinsics(), pose));
  for (int v = 100; v < 297; v += 9) {
    for (int u = 4; u < 396; u += 9) {
      const auto p = floor.floor({static_cast<double>(u), static_cast<double>(v)});
      double u_raw = 0, v_raw = 0;
      if (!p || !camera.distortPixel(u, v, u_raw, v_raw) || u_raw < 3 || v_raw < 3 || u_raw > 396 ||
          v_raw > 296)
        continue;
      const Eigen::Vector2d seen = *p - pose.translation().head<2>();
      if (seen.norm() > 2.0) continue;
      const double line = grid.line(std::atan2(seen.y(), seen.x()));
      EXPECT_GT(line, -1.5);
      EXPECT_LT(line, grid.lines + 1.5);
      EXPECT_LT(grid.row(seen.norm()), grid.rows + 3.0);
      EXPECT_GT(grid.row(seen.norm()), 0.0);
    }
  }
}

TEST(PolarGrid, RawPixelAgreesWithTheGroundHomography) {
  for (const double pitch : {0.0, 0.42, 0.8}) {
    const CameraModel camera = smallCamera();
    const CameraPose pose = cameraPose(0.1, -0.05, 0.4, pitch, 0.1, 0.03);
    const GroundProjection floor(groundHomography(camera.intrinsics(), pose));
    for (const double azimuth : {-0.4, 0.0, 0.3}) {
      for (const double r : {0.3, 0.6, 1.0}) {
        const double d = 0.4 / r;
        const Eigen::Vector2d p = pose.translation().head<2>() +
                                  d * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
        const auto pixel = floor.pixel(p);
        double u = 0, v = 0, u_raw = 0, v_raw = 0;
        ASSERT_TRUE(pixel && rawPixel(camera, pose, azimuth, r, u, v));
        ASSERT_TRUE(camera.distortPixel(pixel->x(), pixel->y(), u_raw, v_raw));
        EXPECT_NEAR(u, u_raw, 1e-9);
        EXPECT_NEAR(v, v_raw, 1e-9);
      }
    }
  }
}

// The fact that the sweep is built on: seen from two places, all of a vertical edge moves by the
// same number of rows.
TEST(PolarGrid, AVerticalEdgeMovesByTheSameNumberOfRowsAtEveryHeight) {
  PolarGrid grid = makePolarGrid(smallCamera(), smallCameraPose(), {}, 2.0);
  const Eigen::Vector2d edge(1.2, 0.3);
  const FootMotion motion(SE2{0.21, 0.02, 0.1}, Eigen::Vector2d(0.05, -0.01));
  const double d = edge.norm(), d_ref = (motion * edge).norm();
  const double expected = grid.rows_per_log * std::log(d / d_ref);
  for (const double z : {0.0, 0.1, 0.25, 0.4}) {
    const double r = (grid.height - z) / d, r_ref = (grid.height - z) / d_ref;
    EXPECT_NEAR((std::log(r_ref) - std::log(r)) * grid.rows_per_log, expected, 1e-9);
  }
}

TEST(PolarGrid, FootMotionIsTheMotionOfTheBaseSeenFromTheFoot) {
  const SE2 motion{0.3, -0.05, 0.2};
  const Eigen::Vector2d foot(0.2, 0.1), p(1.0, 0.4);
  const Eigen::Vector2d expected = motion * (p + foot) - foot;
  EXPECT_LT((FootMotion(motion, foot) * p - expected).norm(), 1e-12);
}

TEST(PolarGrid, AutomaticRangeGrowsWithTheCamera) {
  const CameraModel street(Intrinsics{1226, 370, 707, 707, 602, 183}, {});
  EXPECT_DOUBLE_EQ(effectiveMaxRange(smallCamera(), smallCameraPose(), 0.0), 2.0);
  EXPECT_GT(effectiveMaxRange(street, cameraPose(0, 0, 1.62, 0.012), 0.0), 10.0);
  EXPECT_DOUBLE_EQ(effectiveMaxRange(street, cameraPose(0, 0, 1.62, 0.012), 7.0), 7.0);
}

TEST(PolarGrid, ACameraThatSeesNoFloorWithinRangeGetsNoLines) {
  const CameraModel camera = smallCamera({});
  EXPECT_EQ(makePolarGrid(camera, cameraPose(0, 0, 0.45, -0.8), {}, 2.0).lines, 0);
}

}  // namespace
}  // namespace ipm_mapping::sweep
