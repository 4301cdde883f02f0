#include "ipm_mapping/sweep/self_calibration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>

#include "ipm_mapping/sweep/camera_check.hpp"
#include "ipm_mapping/sweep/sweep_detector.hpp"
#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double degree = M_PI / 180.0;
// Of a camera with 400 x 300 pixels after 1.5 m.
constexpr double pitch_tolerance = 0.15 * degree, height_tolerance = 0.006;

CalibrationParameters smallCalibration() {
  CalibrationParameters p;
  p.row_step = 5;
  p.line_step = 7;
  p.settled_spacing = p.spacing;
  return p;
}

std::string told(const CalibrationReport& r) {
  std::ostringstream out;
  out << r.pairs << " pairs, pitch " << r.pitch.off() / degree << " +- " << r.pitch.sigma / degree
      << " roll " << r.roll.off() / degree << " +- " << r.roll.sigma / degree << " yaw "
      << r.yaw.off() / degree << " height " << r.height.off() << " ratio +- " << r.ratio_sigma
      << " rate " << r.yaw_rate.off();
  return out.str();
}

/// How odometry is wrong: true pose at a time, to what it says.
using Odometry = std::function<SE2(const SE2& truth, double stamp)>;
SE2 honest(const SE2& truth, double) { return truth; }

/// Frames of a gentle curve through a rendered world, taken once for all tests.
struct Recording {
  std::vector<Image<std::uint8_t>> pictures;
  std::vector<SE2> truth;
  test::GrainedScene scene{test::smallCamera(), test::smallCameraPose()};

  Recording() {
    scene.boxes = {{2.3, 2.6, 0.0, 0.5, 0.4}};
    SE2 pose;
    for (int i = 0; i <= 44; ++i) {
      truth.push_back(pose);
      pictures.push_back(scene.render(pose));
      pose = pose * SE2{0.035, 0.0, i < 22 ? 0.012 : -0.012};
    }
  }
};
const Recording& recording() {
  static const Recording once;
  return once;
}

Frame frameOf(std::size_t i, const Odometry& odometry) {
  Frame frame;
  frame.index = i;
  frame.stamp = 0.1 * static_cast<double>(i);
  frame.image = recording().pictures[i].view();
  frame.T_odom_base = odometry(recording().truth[i], frame.stamp);
  return frame;
}

SelfCalibration learn(const CameraPose& stated, const Odometry& odometry,
                      const CalibrationParameters& parameters = smallCalibration(),
                      int pairs = std::numeric_limits<int>::max()) {
  CameraCheck check(test::smallParameters(), parameters);
  check.setCamera(test::smallCamera(), stated);
  Obstacles obstacles;
  for (std::size_t i = 0; i < recording().pictures.size(); ++i) {
    check.process(frameOf(i, odometry), obstacles);
    if (check.calibration()->pairs == pairs) break;
  }
  return check.learnt();
}

CalibrationReport check(const CameraPose& stated, const Odometry& odometry = honest,
                        const CalibrationParameters& parameters = smallCalibration(),
                        int pairs = std::numeric_limits<int>::max()) {
  return learn(stated, odometry, parameters, pairs).report();
}

CameraPose statedPose(double pitch_error, double height_error) {
  return cameraPose(0.05, -0.01, 0.45 + height_error, 0.42 + pitch_error);
}

TEST(SelfCalibration, FindsNothingWrongWithATruePose) {
  const CalibrationReport r = check(statedPose(0.0, 0.0));
  ASSERT_TRUE(r.confident) << told(r);
  EXPECT_NEAR(r.pitch.off(), 0.0, pitch_tolerance) << told(r);
  EXPECT_NEAR(r.roll.off(), 0.0, 0.15 * degree) << told(r);
  EXPECT_NEAR(r.height.off(), 0.0, height_tolerance) << told(r);
  EXPECT_FALSE(r.pitch_off || r.roll_off || r.height_off) << advice(r);
}

class WrongPose : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(WrongPose, IsFoundOut) {
  const auto [pitch_error, height_error] = GetParam();
  const CalibrationReport r = check(statedPose(pitch_error, height_error));
  ASSERT_TRUE(r.confident) << told(r);
  EXPECT_NEAR(r.pitch.estimate, 0.42, pitch_tolerance) << told(r);
  EXPECT_NEAR(r.height.estimate, 0.45, 0.01) << told(r);
  EXPECT_NEAR(r.pitch.stated, 0.42 + pitch_error, 1e-9);
  EXPECT_EQ(r.pitch_off, std::abs(pitch_error) > 0.3 * degree);
}

INSTANTIATE_TEST_SUITE_P(Errors, WrongPose,
                         ::testing::Values(std::pair(1 * degree, 0.0), std::pair(-1 * degree, 0.0),
                                           std::pair(0.0, 0.03), std::pair(0.0, -0.03),
                                           std::pair(2 * degree, 0.03),
                                           std::pair(-2 * degree, -0.03),
                                           std::pair(-2 * degree, 0.04)));

/// What ends on the way says what it began with, and that stays among the evidence.
TEST(SelfCalibration, TheFirstPairsAreAlignedToTheEnd) {
  CalibrationParameters patient = smallCalibration();
  patient.iterations = 50;
  const CameraPose stated = statedPose(0.0, 0.03);
  const CalibrationReport r = check(stated, honest, smallCalibration(), 2);
  const CalibrationReport longer = check(stated, honest, patient, 2);
  ASSERT_EQ(r.pairs, 2);
  EXPECT_NEAR(r.height.estimate, longer.height.estimate, 0.0005) << told(r) << told(longer);
  EXPECT_NEAR(r.pitch.estimate, longer.pitch.estimate, 0.02 * degree) << told(r) << told(longer);
}

/// Axes of the base, wherever the camera looks: the same drive of a robot whose x axis points
/// aside.
TEST(SelfCalibration, RemainingTiltIsInAxesOfTheBase) {
  for (const double heading : {0.0, M_PI / 2.0}) {
    const SE2 T_base_drawn{0.0, 0.0, heading};
    const auto turned = [&](const SE2& truth, double) { return truth * T_base_drawn.inverse(); };
    CameraPose stated = CameraPose::Identity();
    stated.rotate(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()));
    stated = stated * statedPose(-degree, 0.0);
    SelfCalibration calibration = learn(stated, turned);
    const Sway tilt = calibration.remainingTilt();
    EXPECT_NEAR(tilt.at(heading), degree, pitch_tolerance) << heading;
    EXPECT_NEAR(tilt.at(heading + M_PI / 2.0), 0.0, 0.2 * degree) << heading;
    calibration.setCamera(stated);
    EXPECT_EQ(calibration.remainingTilt().size(), 0.0);
  }
}

TEST(SelfCalibration, RollIsFoundOut) {
  const CameraPose stated = cameraPose(0.05, -0.01, 0.45, 0.42, 0.0, 1.0 * degree);
  const CalibrationReport r = check(stated);
  EXPECT_NEAR(r.roll.estimate, -1.0 * degree * std::cos(0.42), 0.2 * degree) << told(r);
  EXPECT_NEAR(r.pitch.estimate, 0.42, pitch_tolerance) << told(r);
}

TEST(SelfCalibration, HeadingDriftOfOdometryIsFoundOut) {
  // At one speed a camera that looks aside looks the same as a drift.
  CalibrationParameters parameters = smallCalibration();
  parameters.sd_yaw = 1e-4;
  const Odometry drifts = [](const SE2&, double stamp) {
    const std::vector<SE2>& truth = recording().truth;
    SE2 pose;
    for (std::size_t i = 1; i <= static_cast<std::size_t>(std::lround(10.0 * stamp)); ++i) {
      SE2 step = truth[i - 1].inverse() * truth[i];
      step.theta += 0.001;
      pose = pose * step;
    }
    return pose;
  };
  const CalibrationReport r = check(statedPose(0.0, 0.0), drifts, parameters);
  EXPECT_NEAR(r.yaw_rate.estimate, -0.01, 0.002) << told(r);
  EXPECT_NEAR(r.pitch.estimate, 0.42, pitch_tolerance) << told(r);
}

/// Odometry that says more way than there was.
Odometry tooLongBy(double share) {
  return [share](const SE2& pose, double) {
    return SE2{(1.0 + share) * pose.x, (1.0 + share) * pose.y, pose.theta};
  };
}

/// The floor shows height over way only. What odometry may be blamed for is not the height's fault.
TEST(SelfCalibration, BlamesOdometryForASmallErrorOfScale) {
  const CalibrationReport r = check(statedPose(0.0, 0.0), tooLongBy(0.02));
  EXPECT_NEAR(r.height.estimate, 0.45, 0.003) << told(r);
  EXPECT_NEAR(r.height.estimate / r.scale.estimate, 0.45 * 1.02, height_tolerance) << told(r);
  EXPECT_LT(r.scale.estimate, 0.99);
}

TEST(SelfCalibration, BlamesTheHeightForMore) {
  const CalibrationReport r = check(statedPose(0.0, -0.03), tooLongBy(0.01));
  EXPECT_NEAR(r.height.estimate, 0.45 * 1.01, height_tolerance) << told(r);
  EXPECT_NEAR(r.scale.estimate, 1.0, 0.004);
  EXPECT_GT(r.scale.sigma, 0.015) << "the two are known no better than their priors";
}

TEST(SelfCalibration, GoesOnComparingUntilTheHeightIsBeyondDoubt) {
  CalibrationParameters rare = smallCalibration();
  rare.settled_spacing = 10.0;
  const CalibrationReport settled = check(statedPose(0.0, 0.0), honest, rare);
  const CalibrationReport doubtful = check(statedPose(0.0, 0.016), honest, rare);
  ASSERT_TRUE(settled.confident);
  EXPECT_GT(doubtful.pairs, settled.pairs);
  EXPECT_NEAR(doubtful.height.estimate, 0.45, height_tolerance) << told(doubtful);
}

TEST(SelfCalibration, WithoutMotionNothingIsLearnt) {
  const CalibrationReport r =
      check(statedPose(degree, 0.0), [](const SE2&, double) { return SE2{}; });
  EXPECT_EQ(r.pairs, 0);
  EXPECT_FALSE(r.believable);
  EXPECT_DOUBLE_EQ(r.pitch.off(), 0.0);
  EXPECT_NE(advice(r).find("not enough floor motion"), std::string::npos);
}

TEST(SelfCalibration, WithoutTextureNothingIsLearnt) {
  CameraCheck check(test::smallParameters(), smallCalibration());
  check.setCamera(test::smallCamera(), statedPose(degree, 0.0));
  Image<std::uint8_t> noise(400, 300);
  Obstacles obstacles;
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    for (int v = 0; v < 300; ++v)
      for (int u = 0; u < 400; ++u)
        noise.at(u, v) = static_cast<std::uint8_t>(110 + static_cast<int>(random() % 9));
    check.process({0, 0.1 * i, noise.view(), {0.05 * i, 0.0, 0.0}}, obstacles);
  }
  EXPECT_EQ(check.calibration()->pairs, 0);
}

TEST(SelfCalibration, AnEstimateBeyondTheBoundsIsNotBelieved) {
  CalibrationParameters tight = smallCalibration();
  tight.max_tilt = 0.5 * degree;
  const CalibrationReport r = check(statedPose(degree, 0.0), honest, tight);
  EXPECT_GE(r.pairs, tight.least_pairs);
  EXPECT_FALSE(r.believable);
  EXPECT_FALSE(r.confident);
  tight = smallCalibration();
  tight.max_height = 0.01;
  EXPECT_FALSE(check(statedPose(0.0, 0.03), honest, tight).believable);
}

TEST(SelfCalibration, EvidenceFadesAndThePriorDoesNot) {
  CalibrationParameters forgetful = smallCalibration();
  forgetful.memory = 2.0;
  const CalibrationReport fades = check(statedPose(0.0, 0.0), honest, forgetful);
  const CalibrationReport keeps = check(statedPose(0.0, 0.0));
  EXPECT_GT(fades.pitch.sigma, 1.2 * keeps.pitch.sigma);
  EXPECT_LE(fades.scale.sigma, forgetful.sd_scale);
}

TEST(CameraCheck, MeasuresThatTheFloorFitsBetterThanAsStated) {
  CameraCheck check(test::smallParameters(), smallCalibration());
  check.setCamera(test::smallCamera(), statedPose(2.0 * degree, 0.0));
  Obstacles obstacles;
  for (std::size_t i = 0; i < recording().pictures.size(); ++i)
    check.process(frameOf(i, honest), obstacles);
  ASSERT_GT(check.view().estimated.size(), 10U);
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  EXPECT_GT(median(check.statedErrors()), 2.0 * median(check.estimatedErrors()));
  EXPECT_LT(median(check.estimatedErrors()), 0.4);
  EXPECT_NEAR(pitchOf(check.T_base_estimated()), 0.42, pitch_tolerance);
}

/// The detector: `report` leaves the pose alone, `apply` works with the estimate.
class CalibratedDetector : public ::testing::Test {
 protected:
  void drive(CalibrationMode mode, const CameraPose& stated) {
    CalibrationParameters p = smallCalibration();
    p.mode = mode;
    detector = std::make_unique<SweepDetector>(test::smallParameters(), p);
    detector->setCamera(test::smallCamera(), stated);
    for (std::size_t i = 0; i < recording().pictures.size(); ++i) {
      const Frame frame = frameOf(i, honest);
      if (detector->process(frame, obstacles) != FrameStatus::Used) continue;
      if (obstacles.contacts.size() <= 3) continue;  // the box is out of sight every other turn
      shown = obstacles;
      T_odom_shown = frame.T_odom_base;
    }
  }
  /// A detector with other parameters that goes on where the driven one stands.
  [[nodiscard]] std::unique_ptr<SweepDetector> successor(CalibrationParameters p,
                                                         CalibrationMode mode) const {
    SweepParameters changed = test::smallParameters();
    changed.grid.max_range = 1.5;
    p.mode = mode;
    auto next = std::make_unique<SweepDetector>(changed, p);
    EXPECT_TRUE(next->adopt(*detector));
    return next;
  }
  /// Mean distance of the shown contacts to the box's outline, metres.
  [[nodiscard]] double error() const {
    double sum = 0.0;
    for (const Contact& c : shown.contacts)
      sum += recording().scene.distanceToOutline(T_odom_shown * c.p_base.cast<double>());
    return sum / static_cast<double>(shown.contacts.size());
  }
  std::unique_ptr<SweepDetector> detector;
  Obstacles obstacles, shown;  // of the last frame, of the last one with contacts
  SE2 T_odom_shown;
};

TEST_F(CalibratedDetector, ReportLeavesTheAnswerAlone) {
  const CameraPose stated = statedPose(degree, 0.02);
  drive(CalibrationMode::Off, stated);
  EXPECT_FALSE(detector->calibration());
  const std::vector<Contact> without = shown.contacts;
  drive(CalibrationMode::Report, stated);
  ASSERT_TRUE(detector->calibration());
  EXPECT_TRUE(detector->calibration()->pitch_off);
  EXPECT_FALSE(detector->calibration()->applied);
  ASSERT_EQ(shown.contacts.size(), without.size());
  for (std::size_t i = 0; i < without.size(); ++i)
    EXPECT_EQ(shown.contacts[i].p_base, without[i].p_base);
  EXPECT_TRUE(shown.view.T_base_camera.isApprox(stated));
}

TEST_F(CalibratedDetector, ApplyFindsTheBoxWhereItIsAndSaysWithWhichPose) {
  drive(CalibrationMode::Apply, statedPose(degree, 0.02));
  ASSERT_TRUE(detector->calibration()->applied);
  EXPECT_NEAR(pitchOf(shown.view.T_base_camera), 0.42, pitch_tolerance);
  EXPECT_NEAR(shown.view.T_base_camera.translation().z(), 0.45, height_tolerance);
  ASSERT_GT(shown.contacts.size(), 3U);
  EXPECT_LT(error(), 0.02);
  EXPECT_NEAR(detector->grid().height, shown.view.T_base_camera.translation().z(), 1e-9);
}

TEST_F(CalibratedDetector, ANewStatedPoseForgetsWhatWasLearnt) {
  drive(CalibrationMode::Apply, statedPose(degree, 0.02));
  detector->setCamera(test::smallCamera(), statedPose(0.0, 0.0));
  EXPECT_EQ(detector->calibration()->pairs, 0);
  EXPECT_FALSE(detector->calibration()->applied);
  EXPECT_NEAR(detector->grid().height, 0.45, 1e-9);
}

TEST_F(CalibratedDetector, OtherParametersKeepWhatWasLearntAndThePoseInForce) {
  drive(CalibrationMode::Apply, statedPose(degree, 0.02));
  const CalibrationReport before = *detector->calibration();
  ASSERT_TRUE(before.applied);
  const auto next = successor(smallCalibration(), CalibrationMode::Apply);
  const CalibrationReport after = *next->calibration();
  EXPECT_EQ(after.pairs, before.pairs);
  EXPECT_EQ(after.confident, before.confident);
  EXPECT_EQ(after.pitch.estimate, before.pitch.estimate);
  EXPECT_EQ(after.pitch.sigma, before.pitch.sigma);
  EXPECT_TRUE(after.applied);
  EXPECT_EQ(next->grid().height, detector->grid().height);
  for (std::size_t i = 0; i < 20; ++i) {
    if (next->process(frameOf(i, honest), obstacles) != FrameStatus::Used) continue;
    EXPECT_NEAR(pitchOf(obstacles.view.T_base_camera), 0.42, pitch_tolerance) << i;
  }
  EXPECT_GT(next->calibration()->pairs, before.pairs);
}

TEST_F(CalibratedDetector, WhatWasReportedIsAppliedAtTheFirstFrame) {
  drive(CalibrationMode::Report, statedPose(degree, 0.02));
  const auto next = successor(smallCalibration(), CalibrationMode::Apply);
  EXPECT_FALSE(next->calibration()->applied);
  EXPECT_EQ(next->process(frameOf(0, honest), obstacles), FrameStatus::NoReference);
  EXPECT_TRUE(next->calibration()->applied);
  EXPECT_NEAR(next->grid().height, 0.45, height_tolerance);
}

TEST_F(CalibratedDetector, WithOtherPriorsItBeginsAnew) {
  drive(CalibrationMode::Apply, statedPose(degree, 0.02));
  CalibrationParameters other = smallCalibration();
  other.sd_pitch *= 2.0;
  const auto next = successor(other, CalibrationMode::Apply);
  EXPECT_EQ(next->calibration()->pairs, 0);
  EXPECT_FALSE(next->calibration()->applied);
  EXPECT_NEAR(next->grid().height, 0.47, 1e-9);
}

TEST_F(CalibratedDetector, WhatTheBoundsNoLongerAllowIsNotInForce) {
  drive(CalibrationMode::Apply, statedPose(degree, 0.02));
  CalibrationParameters tight = smallCalibration();
  tight.max_tilt = 0.5 * degree;
  const auto next = successor(tight, CalibrationMode::Apply);
  EXPECT_EQ(next->calibration()->pairs, detector->calibration()->pairs);
  EXPECT_FALSE(next->calibration()->applied);
  EXPECT_NEAR(next->grid().height, 0.47, 1e-9);
}

TEST_F(CalibratedDetector, AResetKeepsWhatWasLearnt) {
  drive(CalibrationMode::Apply, statedPose(degree, 0.02));
  const int pairs = detector->calibration()->pairs;
  detector->reset();
  EXPECT_EQ(detector->calibration()->pairs, pairs);
  EXPECT_TRUE(detector->calibration()->applied);
}

}  // namespace
}  // namespace ipm_mapping::sweep
