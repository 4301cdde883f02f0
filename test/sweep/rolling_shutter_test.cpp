#include "ipm_mapping/sweep/rolling_shutter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/camera_check.hpp"
#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

using Picture = Image<std::uint8_t>;

/// The camera stands far from where the robot turns about.
class Undone : public ::testing::TestWithParam<std::pair<Velocity, double>> {
 protected:
  Undone() : scene(test::smallCamera(), cameraPose(0.4, -0.2, 0.45, 0.42)) {
    const PolarGrid grid =
        makePolarGrid(scene.camera, scene.T_base_camera, test::smallParameters().grid, 2.0);
    rectification.configure(scene.camera, scene.T_base_camera, grid);
    out.resize(grid.rows, grid.lines);
    truth.resize(grid.rows, grid.lines);
  }
  void configure(double longest) {
    shutter.configure(rectification, scene.T_base_camera.translation().head<2>(), longest);
  }
  /// Mean difference to what a global shutter sees, of what is left of the view, or of its near
  /// end.
  double difference(int nearest = 10000) {
    double sum = 0.0;
    int number = 0;
    for (int line = 0; line < out.height(); ++line) {
      const RowRange rows = shutter.rows()[static_cast<std::size_t>(line)];
      for (int row = std::max(rows.begin, rows.end - nearest); row < rows.end; ++row, ++number)
        sum += std::abs(out.at(row, line) - truth.at(row, line));
    }
    EXPECT_GT(number, nearest < 100 ? 500 : out.height() * out.width() / 3);
    return sum / number;
  }
  test::GrainedScene scene;
  CylindricalRectification rectification;
  RollingShutter shutter;
  Picture out, truth;
};

/// Against the same floor seen by a global shutter, rendered ray by ray.
TEST_P(Undone, TheFloorIsAsAGlobalShutterSeesIt) {
  const auto [velocity, readout] = GetParam();
  const SE2 pose{0.3, 0.1, 0.2};
  configure(readout);
  rectification.rectify(scene.render(pose).view(), truth.view());
  const Picture rolled = scene.render(pose, velocity, readout);
  rectification.rectify(rolled.view(), out.view());
  const double left_in = difference();
  ASSERT_TRUE(shutter.matters(velocity, readout));
  shutter.rectify(rectification, rolled.view(), velocity, readout, out.view());
  EXPECT_GT(left_in, 0.4);
  EXPECT_LT(difference(), 0.25) << "grey levels: rounding, twice";
  if (shutter.reaches(velocity, readout)) {
    EXPECT_LT(difference(4), 0.4) << "at the near end, where the way leads below the image";
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, Undone,
                         ::testing::Values(std::pair(Velocity{0.0, 0.0, 0.7}, 0.03),
                                           std::pair(Velocity{0.5, 0.0, 0.0}, 0.03),
                                           std::pair(Velocity{0.3, 0.0, -0.7}, 0.03),
                                           std::pair(Velocity{0.3, 0.2, 0.5}, 0.025),
                                           std::pair(Velocity{0.45, 0.0, 0.25}, 0.03),
                                           std::pair(Velocity{0.45, 0.0, -0.25}, -0.03),
                                           std::pair(Velocity{0.3, 0.0, 0.7}, -0.03)));

using RollingShutterTest = Undone;

TEST_F(RollingShutterTest, WithoutOneNothingOfTheViewIsLost) {
  configure(0.0);
  for (std::size_t i = 0; i < shutter.rows().size(); ++i) {
    EXPECT_EQ(shutter.rows()[i].begin, rectification.ranges()[i].begin);
    EXPECT_EQ(shutter.rows()[i].end, rectification.ranges()[i].end);
  }
  EXPECT_FALSE(shutter.matters({1.0, 0.0, 1.0}, 0.0));
}

TEST_F(RollingShutterTest, SlowMotionDoesNotMatter) {
  configure(0.03);
  EXPECT_FALSE(shutter.matters({0.001, 0.0, 0.001}, 0.03));
  EXPECT_TRUE(shutter.matters({0.0, 0.0, 0.1}, 0.03));
  EXPECT_TRUE(shutter.matters({0.0, 0.0, -0.1}, 0.03));
}

TEST_F(RollingShutterTest, SaysWhatIsTooFastForIt) {
  configure(0.03);
  EXPECT_TRUE(shutter.reaches({0.3, 0.0, 0.3}, 0.03));
  EXPECT_TRUE(shutter.reaches({0.3, 0.0, 0.7}, 0.015));
  EXPECT_FALSE(shutter.reaches({0.3, 0.0, 1.4}, 0.03));
  EXPECT_FALSE(shutter.reaches({0.3, 0.0, -1.4}, -0.03));
  EXPECT_FALSE(shutter.reaches({2.0, 0.0, 0.0}, 0.03));
}

/// The way leads rows at the near end farther down: the image has to go on there.
TEST_F(RollingShutterTest, WhatIsLeftOfTheViewIsInTheImageWhenItWasRead) {
  configure(0.03);
  const PolarGrid& grid = rectification.grid();
  for (int line = 0; line < grid.lines; ++line) {
    const RowRange rows = shutter.rows()[static_cast<std::size_t>(line)];
    if (rows.size() == 0) continue;
    const int row = rows.end - 1;
    const double way =
        0.03 * static_cast<double>(rectification.readTime(row, line)) * RollingShutter::fastest_way;
    const double led = row + way / grid.distance(row) * grid.rows_per_log;
    double u = 0.0, v = 0.0;
    ASSERT_TRUE(rawPixel(scene.camera, scene.T_base_camera, grid.azimuth(line), grid.r(led), u, v));
    EXPECT_LE(v, scene.camera.height() - 3.0) << line;
  }
}

TEST_F(RollingShutterTest, BesideTheViewThatIsLeftNothingIsShown) {
  configure(0.03);
  out.resize(out.width(), out.height(), 200);
  shutter.blankOutside(out);
  int shown = 0, left = 0;
  for (int line = 0; line < out.height(); ++line) {
    for (int row = 0; row < out.width(); ++row) {
      const bool inside = shutter.rows()[static_cast<std::size_t>(line)].contains(row);
      ASSERT_EQ(out.at(row, line), inside ? 200 : 0);
      shown += inside;
      left += rectification.ranges()[static_cast<std::size_t>(line)].contains(row);
    }
  }
  EXPECT_LT(shown, left);
  EXPECT_GT(shown, 0.85 * left);
}

/// A turn faster than the view has room for stays within the image.
TEST_F(RollingShutterTest, ATurnThatIsTooFastIsUndoneInPart) {
  configure(0.03);
  const Velocity fast{0.0, 0.0, 3.0};
  const SE2 pose{0.3, 0.1, 0.2};
  rectification.rectify(scene.render(pose).view(), truth.view());
  const Picture rolled = scene.render(pose, fast, 0.03);
  rectification.rectify(rolled.view(), out.view());
  const double left_in = difference();
  shutter.rectify(rectification, rolled.view(), fast, 0.03, out.view());
  EXPECT_LT(difference(), 0.9 * left_in);
}

/// A weaving drive, taken with several shutters.
class Weave {
 public:
  explicit Weave(double readout) : scene_(test::smallCamera(), test::smallCameraPose()) {
    SE2 pose;
    for (int i = 0; i <= 40; ++i) {
      const Velocity velocity{0.35, 0.0, i / 8 % 2 == 0 ? 0.0 : (i / 16 % 2 == 0 ? 0.6 : -0.6)};
      velocity_.push_back(velocity);
      truth_.push_back(pose);
      pictures_.push_back(scene_.render(pose, velocity, readout));
      const double half = 0.05 * velocity.theta;
      pose = pose * SE2{0.0, 0.0, half} * SE2{0.1 * velocity.x, 0.0, half};
    }
  }
  [[nodiscard]] std::size_t size() const { return pictures_.size(); }
  [[nodiscard]] Frame frame(std::size_t i) const {
    return {i, 0.1 * static_cast<double>(i), pictures_[i].view(), truth_[i], velocity_[i]};
  }

 private:
  test::GrainedScene scene_;
  std::vector<Picture> pictures_;
  std::vector<SE2> truth_;
  std::vector<Velocity> velocity_;
};
const Weave& weave(double readout) {
  static const Weave global(0.0), rolling(0.03), upside_down(-0.02);
  return readout == 0.0 ? global : readout > 0.0 ? rolling : upside_down;
}

CalibrationReport checked(const Weave& drive, const CalibrationParameters& parameters) {
  CameraCheck check(test::smallParameters(), parameters);
  check.setCamera(test::smallCamera(), test::smallCameraPose());
  Obstacles obstacles;
  for (std::size_t i = 0; i < drive.size(); ++i) check.process(drive.frame(i), obstacles);
  return *check.calibration();
}

class Readout : public ::testing::TestWithParam<double> {};

TEST_P(Readout, IsFoundOut) {
  const CalibrationReport r = checked(weave(GetParam()), test::patientCalibration());
  EXPECT_NEAR(r.readout.estimate, GetParam(), 0.004);
  EXPECT_LT(r.readout.sigma, 0.003);
  EXPECT_NEAR(r.pitch.off(), 0.0, 0.003);
  EXPECT_NEAR(r.height.off(), 0.0, 0.006);
}
INSTANTIATE_TEST_SUITE_P(Shutters, Readout, ::testing::Values(0.0, 0.03, -0.02));

TEST(ReadoutTime, ThatIsKnownIsNotLearnt) {
  CalibrationParameters known = test::patientCalibration();
  known.readout_time = 0.01;
  known.learn_readout = false;
  const CalibrationReport r = checked(weave(0.03), known);
  EXPECT_NEAR(r.readout.estimate, 0.01, 1e-4);
  EXPECT_EQ(r.readout.stated, 0.01);
}

/// How well two views of an empty floor agree at the worst moment of a drive, grey levels.
class EmptyFloor : public ::testing::Test {
 protected:
  double drive(const Weave& drive, const CalibrationParameters& p) {
    detector = std::make_unique<SweepDetector>(test::smallParameters(), p);
    detector->setCamera(test::smallCamera(), test::smallCameraPose());
    return again(drive);
  }
  double again(const Weave& drive) {
    double worst = 0.0;
    for (std::size_t i = 0; i < drive.size(); ++i)
      if (detector->process(drive.frame(i), obstacles) == FrameStatus::Used)
        worst = std::max(worst, residual());
    return worst;
  }
  [[nodiscard]] double residual() const {
    const ImageView<const std::int16_t> all = detector->residual();
    double sum = 0.0;
    int number = 0;
    for (int line = 0; line < all.height; ++line) {
      for (int row = 0; row < all.width; ++row) {
        if (all.row(line)[row] == kernels::no_residual) continue;
        sum += std::abs(all.row(line)[row]);
        ++number;
      }
    }
    return sum / kernels::grey_unit / std::max(number, 1);
  }
  std::unique_ptr<SweepDetector> detector;
  Obstacles obstacles;
};

TEST_F(EmptyFloor, LooksTheSameWhileWeaving) {
  CalibrationParameters off = test::patientCalibration();
  off.mode = CalibrationMode::Off;
  const double global = drive(weave(0.0), off), rolling = drive(weave(0.03), off);
  ASSERT_GT(rolling, 2.0 * global) << "the drive shows what a rolling shutter does";
  CalibrationParameters stated = off;
  stated.readout_time = 0.03;
  EXPECT_LT(drive(weave(0.03), stated), 1.1 * global);
  stated.readout_time = -0.02;
  EXPECT_LT(drive(weave(-0.02), stated), 1.1 * global);
}

TEST_F(EmptyFloor, WhatWasLearntServesFromThenOn) {
  const double global = drive(weave(0.0), test::patientCalibration());
  drive(weave(0.03), test::patientCalibration());
  EXPECT_NEAR(detector->readout(), 0.03, 0.004);
  detector->reset();
  EXPECT_LT(again(weave(0.03)), 1.15 * global);
  // a detector with other parameters goes on with it, and one whose camera is mounted elsewhere
  SweepParameters changed = test::smallParameters();
  changed.grid.max_range = 1.5;
  SweepDetector next(changed, test::patientCalibration());
  ASSERT_TRUE(next.adopt(*detector));
  EXPECT_NEAR(next.readout(), detector->readout(), 0.002);
  const double learnt = detector->readout();
  detector->setCamera(test::smallCamera(), test::smallCameraPose(0.5));
  EXPECT_EQ(detector->readout(), learnt);
  detector->setCamera(test::smallCamera({}), test::smallCameraPose(0.5));
  EXPECT_EQ(detector->readout(), 0.0);
}

/// Frames that were sheared beyond what the view has room for would be taken for a longer readout.
TEST_F(EmptyFloor, TurnsThatAreTooFastDoNotMislead) {
  drive(weave(0.03), test::patientCalibration());
  const double before = detector->calibration()->readout.estimate;
  const int pairs = detector->calibration()->pairs;
  const test::GrainedScene scene(test::smallCamera(), test::smallCameraPose());
  SE2 pose;
  for (std::size_t i = 0; i < 12; ++i) {
    const Velocity velocity{0.6, 0.0, i % 4 < 2 ? 2.0 : -2.0};
    const Picture picture = scene.render(pose, velocity, 0.03);
    detector->process({i, 100.0 + 0.05 * static_cast<double>(i), picture.view(), pose, velocity},
                      obstacles);
    pose = pose * SE2{0.03, 0.0, 0.05 * velocity.theta};
  }
  EXPECT_EQ(detector->calibration()->pairs, pairs);
  EXPECT_EQ(detector->calibration()->readout.estimate, before);
}

TEST_F(EmptyFloor, AGlobalShutterStaysOne) {
  drive(weave(0.0), test::patientCalibration());
  EXPECT_EQ(detector->readout(), 0.0);
}

TEST_F(EmptyFloor, NothingIsLearntWhereThatIsNotWanted) {
  CalibrationParameters p = test::patientCalibration();
  p.learn_readout = false;
  drive(weave(0.03), p);
  EXPECT_EQ(detector->readout(), 0.0);
  p.learn_readout = true;
  p.mode = CalibrationMode::Off;
  drive(weave(0.03), p);
  EXPECT_EQ(detector->readout(), 0.0);
}

}  // namespace
}  // namespace ipm_mapping::sweep
