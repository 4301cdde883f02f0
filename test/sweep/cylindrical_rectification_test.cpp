#include "ipm_mapping/sweep/cylindrical_rectification.hpp"

#include <gtest/gtest.h>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

using test::smallCamera;
using test::smallCameraPose;

/// A smooth picture: interpolation and smoothing hardly change it.
double wave(double u, double v) { return 128.0 + 60.0 * std::sin(0.11 * u) * std::cos(0.08 * v); }

class Rectification : public ::testing::TestWithParam<double> {
 protected:
  void SetUp() override {
    grid = makePolarGrid(camera, pose, {}, 2.0);
    rectification.configure(camera, pose, grid);
  }
  CameraModel camera = smallCamera();
  CameraPose pose = cameraPose(0.05, 0.0, 0.45, GetParam(), 0.05, 0.02);
  PolarGrid grid;
  CylindricalRectification rectification;
};

TEST_P(Rectification, ShowsAtEveryPixelWhatItsRaySees) {
  Image<std::uint8_t> raw(camera.width(), camera.height());
  for (int v = 0; v < raw.height(); ++v)
    for (int u = 0; u < raw.width(); ++u)
      raw.at(u, v) = static_cast<std::uint8_t>(std::lround(wave(u, v)));
  Image<std::uint8_t> out(grid.rows, grid.lines);
  rectification.rectify(raw.view(), out.view());
  int seen = 0;
  for (int line = 0; line < grid.lines; ++line) {
    const RowRange rows = rectification.rows(line);
    for (int row = rows.begin; row < rows.end; ++row) {
      double u = 0, v = 0;
      ASSERT_TRUE(rawPixel(camera, pose, grid.azimuth(line), grid.r(row), u, v));
      ASSERT_NEAR(out.at(row, line), wave(u, v), 2.0) << line << ' ' << row;
      ++seen;
    }
  }
  EXPECT_GT(seen, grid.lines * grid.rows / 4);
}

TEST_P(Rectification, RowsInViewAreExactlyThoseWhoseRayHitsTheImage) {
  for (int line = 0; line < grid.lines; line += 5) {
    for (int row = 0; row < grid.rows; ++row) {
      double u = 0, v = 0;
      const bool inside = rawPixel(camera, pose, grid.azimuth(line), grid.r(row), u, v) && u >= 2 &&
                          v >= 2 && u < camera.width() - 3 && v < camera.height() - 3;
      EXPECT_EQ(rectification.rows(line).contains(row), inside) << line << ' ' << row;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Pitches, Rectification, ::testing::Values(0.0, 0.42, 0.7));

TEST(CommonRows, AreTheIntersectionOfTheLines) {
  const std::vector<RowRange> rows{{0, 10}, {2, 12}, {1, 9}, {5, 20}};
  const auto common = commonRows(rows, 3);
  ASSERT_EQ(common.size(), 2U);
  EXPECT_EQ(common[0].begin, 2);
  EXPECT_EQ(common[0].end, 9);
  EXPECT_EQ(common[1].begin, 5);
  EXPECT_EQ(common[1].end, 9);
}

}  // namespace
}  // namespace ipm_mapping::sweep
