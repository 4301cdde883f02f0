#include "ipm_mapping/sweep/sway.hpp"

#include <gtest/gtest.h>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

/// The same place seen twice, level and swayed.
class SwayTest : public ::testing::Test {
 protected:
  void SetUp() override {
    grid = makePolarGrid(scene.camera, scene.T_base_camera, test::smallParameters().grid, 2.0);
    rectification.configure(scene.camera, scene.T_base_camera, grid);
    correction.configure(grid, rectification.ranges());
  }
  Image<std::uint8_t> rectified(const Sway& sway) {
    Image<std::uint8_t> image(grid.rows, grid.lines);
    const Image<std::uint8_t> raw = scene.render(SE2{}, sway);
    rectification.rectify(raw.view(), image.view());
    return image;
  }
  /// Root mean square of the grey levels' difference where both are in view.
  double difference(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) const {
    double sum = 0.0;
    int n = 0;
    for (int line = margin; line < grid.lines - margin; ++line) {
      const RowRange rows =
          intersection(rectification.rows(line - 4), rectification.rows(line + 4));
      for (int row = rows.begin + margin; row < rows.end - margin; ++row, ++n)
        sum += std::pow(a.at(row, line) - b.at(row, line), 2);
    }
    return std::sqrt(sum / n);
  }
  static constexpr int margin = 12;
  test::GrainedScene scene{test::smallCamera(), test::smallCameraPose()};
  PolarGrid grid;
  CylindricalRectification rectification;
  SwayCorrection correction;
  std::vector<RowRange> seen;
};

TEST(Sway, LooksDownByWhatTheAttitudeSays) {
  const Sway sway{0.004, -0.003};
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(sway.pitch, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(sway.roll, Eigen::Vector3d::UnitX()))
                                .matrix();
  for (const double azimuth : {-1.2, 0.0, 0.5, 2.0}) {
    const Eigen::Vector3d ahead(std::cos(azimuth), std::sin(azimuth), 0.0);
    EXPECT_NEAR(-std::asin((R * ahead).z()), sway.at(azimuth), 2e-5) << azimuth;
  }
}

TEST_F(SwayTest, RemovedItIsGone) {
  const Image<std::uint8_t> level = rectified({});
  Image<std::uint8_t> removed(grid.rows, grid.lines);
  for (const Sway sway : {Sway{0.005, 0.0}, Sway{-0.005, 0.0}, Sway{0.0, 0.006}, Sway{0.0, -0.006},
                          Sway{0.004, -0.004}}) {
    const Image<std::uint8_t> swayed = rectified(sway);
    correction.remove(sway, swayed, removed, seen);
    EXPECT_LT(difference(removed, level), 0.35 * difference(swayed, level))
        << sway.pitch << ' ' << sway.roll;
  }
}

/// From the left end of the view to the right, as far as lines beside are seen too.
TEST_F(SwayTest, IsRemovedOnEveryLine) {
  const Sway sway{0.005, 0.0};
  const Image<std::uint8_t> level = rectified({}), swayed = rectified(sway);
  Image<std::uint8_t> removed(grid.rows, grid.lines);
  correction.remove(sway, swayed, removed, seen);
  int lines = 0;
  for (int line = 2; line < grid.lines - 2; ++line) {
    double before = 0.0, after = 0.0;
    const RowRange rows = intersection(rectification.rows(line - 2), rectification.rows(line + 2));
    if (rows.size() < 20) continue;
    for (int row = rows.begin + 4; row < rows.end - 4; ++row) {
      before += std::pow(swayed.at(row, line) - level.at(row, line), 2);
      after += std::pow(removed.at(row, line) - level.at(row, line), 2);
    }
    EXPECT_LT(after, 0.6 * before) << line << " of " << grid.lines;
    ++lines;
  }
  EXPECT_GT(lines, grid.lines / 2);
}

/// A view without corners: only the outermost two lines have too few beside them.
TEST_F(SwayTest, TheEndsOfTheViewAreTreatedAlike) {
  correction.configure(
      grid, std::vector<RowRange>(static_cast<std::size_t>(grid.lines), RowRange{0, grid.rows}));
  Image<std::uint8_t> waves(grid.rows, grid.lines), removed(grid.rows, grid.lines);
  for (int line = 0; line < grid.lines; ++line)
    for (int row = 0; row < grid.rows; ++row)
      waves.at(row, line) = static_cast<std::uint8_t>(100.0 + 80.0 * std::sin(0.3 * row));
  correction.remove({0.005, 0.0}, waves, removed, seen);
  for (int line = 0; line < grid.lines; ++line)
    EXPECT_EQ(std::equal(waves.row(line), waves.row(line) + grid.rows, removed.row(line)),
              line < 2 || line >= grid.lines - 2)
        << line << " of " << grid.lines;
}

/// Rows are called seen as far as they show what the definition fetches, and no farther.
TEST_F(SwayTest, SaysWhichRowsItHadFromTheView) {
  const auto wave = [](double row) { return 100.0 + 80.0 * std::sin(0.3 * row); };
  correction.configure(
      grid, std::vector<RowRange>(static_cast<std::size_t>(grid.lines), RowRange{0, grid.rows}));
  Image<std::uint8_t> waves(grid.rows, grid.lines), removed(grid.rows, grid.lines);
  for (int line = 0; line < grid.lines; ++line)
    for (int row = 0; row < grid.rows; ++row)
      waves.at(row, line) = static_cast<std::uint8_t>(std::lround(wave(row)));
  for (const double pitch : {0.005, -0.005}) {
    correction.remove({pitch, 0.0}, waves, removed, seen);
    ASSERT_EQ(seen.size(), static_cast<std::size_t>(grid.lines));
    for (int line = 0; line < grid.lines; ++line) {
      const RowRange rows = seen[static_cast<std::size_t>(line)];
      if (line < 2 || line >= grid.lines - 2) {
        EXPECT_EQ(rows.size(), 0) << line;
        continue;
      }
      for (int row = 0; row < grid.rows; ++row) {
        const double r = grid.r(row);
        const double from =
            row - grid.rows_per_log * pitch * std::cos(grid.azimuth(line)) * (1.0 + r * r) / r;
        const double inside = std::min(from, grid.rows - 1 - from);
        if (std::abs(inside) > 1e-3) {
          EXPECT_EQ(rows.contains(row), inside > 0.0) << row << ' ' << line;
        }
        if (rows.contains(row)) {
          EXPECT_NEAR(removed.at(row, line), wave(from), 2.5);
        }
      }
    }
  }
}

TEST_F(SwayTest, NoneChangesNothing) {
  const Image<std::uint8_t> level = rectified({});
  Image<std::uint8_t> same(grid.rows, grid.lines);
  correction.remove({}, level, same, seen);
  for (int line = 0; line < grid.lines; ++line)
    for (int row = 0; row < grid.rows; ++row)
      ASSERT_EQ(same.at(row, line), level.at(row, line)) << row << ' ' << line;
}

}  // namespace
}  // namespace ipm_mapping::sweep
