#include "ipm_mapping/sweep/lens_shading.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "sweep/drive.hpp"

namespace ipm_mapping::sweep {
namespace {

using test::Drive;

class Shading : public ::testing::Test {
 protected:
  Shading() : camera(test::smallCamera()), pose(test::smallCameraPose()) {
    grid = makePolarGrid(camera, pose, test::smallParameters().grid, 2.0);
    rectification.configure(camera, pose, grid);
  }
  /// Floor of a pair, seen `rows` farther in the reference, by a lens that shades; gloss makes it
  /// brighter where it is looked at less steeply.
  void learn(LensShading& lens, double shading, double gloss, double gain = 1.0, int rows = 30) {
    std::vector<float> current, before, reference_row, reference_line;
    std::vector<int> row, line;
    std::uniform_real_distribution<double> grey(40.0, 160.0);
    std::normal_distribution<double> noise(0.0, 1.0);
    for (int l = 2; l + 2 < grid.lines; l += 4)
      for (int r = rectification.rows(l).begin + rows + 1; r < rectification.rows(l).end - 1;
           r += 5) {
        const double I = grey(random);
        const auto seen = [&](int at, double brightness) {
          const double shade =
              1.0 - shading * static_cast<double>(rectification.squaredRadius(at, l));
          return brightness * I * shade * (1.0 + gloss * std::log(grid.distance(at))) +
                 noise(random);
        };
        row.push_back(r);
        line.push_back(l);
        reference_row.push_back(static_cast<float>(r - rows));
        reference_line.push_back(static_cast<float>(l));
        current.push_back(static_cast<float>(seen(r, 1.0)));
        before.push_back(static_cast<float>(seen(r - rows, gain)));
      }
    const int count = static_cast<int>(row.size());
    ASSERT_GT(count, 500);
    lens.learn(rectification, {current.data(), before.data(), row.data(), line.data(),
                               reference_row.data(), reference_line.data(), count, 1.5});
  }
  CameraModel camera;
  CameraPose pose;
  PolarGrid grid;
  CylindricalRectification rectification;
  CalibrationParameters parameters;
  std::mt19937 random{5};
};

TEST_F(Shading, IsFoundWhateverGlossAndExposureDo) {
  for (const double shading : {0.0, 0.08, 0.2})
    for (const double gloss : {0.0, 0.05, -0.05})
      for (const double gain : {1.0, 1.02}) {
        LensShading lens;
        lens.configure(parameters);
        for (int i = 0; i < 40; ++i) learn(lens, shading, gloss, gain);
        EXPECT_NEAR(lens.estimate(), shading, 0.02) << "gloss " << gloss << ", gain " << gain;
        EXPECT_LT(lens.sigma(), 0.01);
        EXPECT_EQ(lens.differs(0.0), shading > 0.0);
        EXPECT_FALSE(lens.differs(lens.estimate() + 0.005));
      }
}

TEST_F(Shading, WhatIsTakenOffAlreadyCounts) {
  rectification.setShading(0.15);
  LensShading lens;
  lens.configure(parameters);
  for (int i = 0; i < 40; ++i) learn(lens, 0.05, 0.0);  // is left
  EXPECT_NEAR(lens.estimate(), 0.2, 0.015);
}

TEST_F(Shading, IsWhatIsStatedUntilPairsSayOtherwise) {
  parameters.lens_shading = 0.1;
  LensShading lens;
  lens.configure(parameters);
  EXPECT_DOUBLE_EQ(lens.estimate(), 0.1);
  EXPECT_NEAR(lens.sigma(), parameters.sd_shading, 1e-9);
  for (int i = 0; i < parameters.shading_pairs - 1; ++i) learn(lens, 0.3, 0.0);
  EXPECT_FALSE(lens.differs(0.0)) << "too few";
  learn(lens, 0.3, 0.0);
  EXPECT_TRUE(lens.differs(0.0));
  lens.forget();
  EXPECT_DOUBLE_EQ(lens.estimate(), 0.1);
}

TEST_F(Shading, OldPairsFade) {
  parameters.shading_memory = 10.0;
  LensShading lens;
  lens.configure(parameters);
  for (int i = 0; i < 40; ++i) learn(lens, 0.2, 0.0);
  for (int i = 0; i < 40; ++i) learn(lens, 0.05, 0.0);
  EXPECT_NEAR(lens.estimate(), 0.05, 0.02);
}

TEST_F(Shading, IsNotBelievedBeyondItsBound) {
  parameters.max_shading = 0.1;
  LensShading lens;
  lens.configure(parameters);
  for (int i = 0; i < 20; ++i) learn(lens, 0.3, 0.0);
  EXPECT_DOUBLE_EQ(lens.estimate(), 0.1);
  lens.forget();
  for (int i = 0; i < 20; ++i) learn(lens, -0.2, 0.0);
  EXPECT_DOUBLE_EQ(lens.estimate(), 0.0) << "no lens brightens the corners";
  EXPECT_FALSE(lens.differs(0.0));
}

TEST_F(Shading, TooLittleFloorSaysNothing) {
  LensShading lens;
  lens.configure(parameters);
  const std::vector<float> grey(100, 100.0F), place(100, 5.0F);
  const std::vector<int> row(100, 5);
  lens.learn(rectification, {grey.data(), grey.data(), row.data(), row.data(), place.data(),
                             place.data(), 100, 1.0});
  EXPECT_EQ(lens.pairs(), 0);
}

TEST_F(Shading, IsTakenOffARectifiedImage) {
  Image<std::uint8_t> picture(camera.width(), camera.height());
  std::fill(picture.row(0), picture.row(picture.height()), std::uint8_t{150});
  test::shadeCorners(0.25, picture);
  Image<std::uint8_t> plain(grid.rows, grid.lines), again(grid.rows, grid.lines);
  rectification.rectify(picture.view(), again.view());
  rectification.setShading(0.25);
  rectification.rectify(picture.view(), plain.view());
  rectification.shadeAgain(0.0, again.view());
  int darkest = 255;
  for (int line = 0; line < grid.lines; ++line)
    for (int row = rectification.rows(line).begin; row < rectification.rows(line).end; ++row) {
      ASSERT_NEAR(plain.at(row, line), 150, 1) << row << ", " << line;
      ASSERT_NEAR(again.at(row, line), 150, 1) << row << ", " << line;
      darkest = std::min(darkest, static_cast<int>(again.at(row, line)));
    }
  std::fill(picture.row(0), picture.row(picture.height()), std::uint8_t{250});
  rectification.rectify(picture.view(), plain.view());
  for (int line = 0; line < grid.lines; ++line)
    for (int row = rectification.rows(line).begin; row < rectification.rows(line).end; ++row)
      ASSERT_GE(plain.at(row, line), 250) << "too bright is white, not black";
}

/// The detector as a whole, its camera darkening by 15 %.
class ShadedDrive : public ::testing::Test {
 protected:
  static constexpr double shading = 0.15;
  static CalibrationParameters with(double stated, bool learn) {
    CalibrationParameters p;
    p.lens_shading = stated;
    p.learn_shading = learn;
    return p;
  }
  /// Spread of the floor's residual over the second half of a drive, and what is found at last.
  static double drive(Drive& robot) {
    robot.shading = shading;
    double worst = 0.0;
    for (int i = 0; i <= 40; ++i) {
      robot.at({0.02 * i, 0.0, 0.02 * std::sin(0.3 * i)});
      if (i > 20) worst = std::max(worst, robot.detector.refinedMotion(1).sigma);
    }
    return worst;
  }
};

TEST_F(ShadedDrive, IsLearntAndTakenOff) {
  Drive learns(test::smallParameters(), 0.42, with(0.0, true));
  Drive ignores(test::smallParameters(), 0.42, with(0.0, false));
  Drive knows(test::smallParameters(), 0.42, with(shading, false));
  const double left = drive(learns), ignored = drive(ignores), known = drive(knows);
  EXPECT_NEAR(learns.detector.calibration()->shading.estimate, shading, 0.03);
  EXPECT_LT(left, known + 0.5 * (ignored - known)) << ignored << " ignored, " << known << " known";
  EXPECT_DOUBLE_EQ(ignores.detector.lensShading(), 0.0);
  EXPECT_DOUBLE_EQ(knows.detector.lensShading(), shading);
}

TEST_F(ShadedDrive, IsKeptByTheNextDetectorAndForgottenWithTheCamera) {
  Drive robot(test::smallParameters(), 0.42, with(0.0, true));
  drive(robot);
  const double learnt = robot.detector.lensShading();
  ASSERT_GT(learnt, 0.05);
  SweepDetector next(test::smallParameters(), with(0.0, true));
  ASSERT_TRUE(next.adopt(robot.detector));
  EXPECT_DOUBLE_EQ(next.lensShading(), learnt);
  EXPECT_NEAR(next.calibration()->shading.estimate, robot.detector.calibration()->shading.estimate,
              1e-9);
  robot.detector.reset();
  EXPECT_DOUBLE_EQ(robot.detector.lensShading(), learnt) << "the lens is the same";
  robot.detector.setCamera(test::smallCamera({}), robot.scene.T_base_camera);
  EXPECT_DOUBLE_EQ(robot.detector.lensShading(), 0.0);
  EXPECT_DOUBLE_EQ(robot.detector.calibration()->shading.estimate, 0.0);
}

}  // namespace
}  // namespace ipm_mapping::sweep
