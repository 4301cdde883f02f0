// Images whose stamps are off odometry's clock, on a robot that weaves, through the gate that gives
// frames their poses: what the stamps are off is found out, and later frames come right.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "ipm_mapping/frame_gate.hpp"
#include "ipm_mapping/sweep/camera_check.hpp"
#include "ipm_mapping/sweep/sweep_detector.hpp"
#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double frame_period = 0.1, odometry_period = 0.02;
constexpr int frames = 32;

/// An empty floor, seen at even times while the turn swings.
class Swing {
 public:
  Swing() : scene_(test::smallCamera(), test::smallCameraPose()) {
    for (SE2 pose; time() < end; pose = pose * exponential({speed * tick, 0.0, turn() * tick}))
      poses_.push_back(pose);
    for (int i = 0; i < frames; ++i) pictures_.push_back(scene_.render(at(frame_period * i)));
  }
  [[nodiscard]] const Image<std::uint8_t>& picture(int i) const {
    return pictures_[static_cast<std::size_t>(i)];
  }
  /// From a second before the first picture to a second after the last.
  [[nodiscard]] SE2 at(double t) const {
    return poses_[static_cast<std::size_t>(std::lround((t - begin) / tick))];
  }
  static constexpr double begin = -1.0, end = frames * frame_period + 1.0;

 private:
  static constexpr double tick = 0.0005, speed = 0.3;
  [[nodiscard]] double time() const { return begin + tick * static_cast<double>(poses_.size()); }
  [[nodiscard]] double turn() const { return 0.7 * std::sin(2.5 * time()); }

  test::GrainedScene scene_;
  std::vector<SE2> poses_;
  std::vector<Image<std::uint8_t>> pictures_;
};
const Swing& swing() {
  static const Swing once;
  return once;
}

/// Images with stamps that are `late`, odometry with the right ones, both to a detector.
class LateImages {
 public:
  explicit LateImages(double late) : late_(late) {}

  void drive(Detector& detector,
             const std::function<void(const Frame&, FrameStatus)>& seen = {}) const {
    FrameGate<int> gate;
    gate.setTimeOffset(detector.timeOffset());
    for (double t = Swing::begin; t < Swing::end - 0.01; t += odometry_period)
      gate.addOdometry(t, swing().at(t));
    for (int i = 0; i < frames; ++i) {
      gate.addFrame(frame_period * i + late_, i);
      FrameGate<int>::Released released;
      while (gate.next(released)) {
        const Frame frame{static_cast<std::uint64_t>(released.payload),
                          released.stamp,
                          swing().picture(released.payload).view(),
                          released.T_odom_base,
                          released.velocity,
                          released.time_offset};
        Obstacles obstacles;
        const FrameStatus status = detector.process(frame, obstacles);
        gate.setTimeOffset(detector.timeOffset());
        if (seen) seen(frame, status);
      }
    }
  }

 private:
  double late_;
};

class TimeOffset : public ::testing::TestWithParam<double> {};

TEST_P(TimeOffset, IsFoundOutAndFramesComeRight) {
  const double late = GetParam();
  CameraCheck check(test::smallParameters(), test::patientCalibration());
  check.setCamera(test::smallCamera(), test::smallCameraPose());
  double last = 0.0;
  LateImages(late).drive(check, [&](const Frame& frame, FrameStatus) { last = frame.time_offset; });
  const CalibrationReport r = *check.calibration();
  EXPECT_NEAR(r.time_offset.estimate, -late, 0.003);
  EXPECT_LT(r.time_offset.sigma, 0.005);
  EXPECT_LT(std::abs(r.time_offset.off() + late), 2.0 * r.time_offset.sigma);
  EXPECT_NEAR(last, -late, 0.006);
  EXPECT_NEAR(r.pitch.off(), 0.0, 0.003);
  EXPECT_NEAR(r.height.off(), 0.0, 0.008);
  EXPECT_NEAR(r.readout.estimate, 0.0, 0.005) << "not taken for a rolling shutter";
}
INSTANTIATE_TEST_SUITE_P(Clocks, TimeOffset, ::testing::Values(0.0, 0.05, -0.04, 0.1));

class LateDetector : public ::testing::Test {
 protected:
  std::unique_ptr<SweepDetector> drive(double late, const CalibrationParameters& parameters) {
    auto detector = std::make_unique<SweepDetector>(test::smallParameters(), parameters);
    detector->setCamera(test::smallCamera(), test::smallCameraPose());
    LateImages(late).drive(*detector);
    return detector;
  }
  /// How far odometry's motion between two frames is from the floor's, at its worst.
  static double worstMotion(Detector& any, double late) {
    auto& detector = dynamic_cast<SweepDetector&>(any);
    double worst = 0.0;
    int compared = 0;
    std::vector<Frame> seen;
    LateImages(late).drive(detector, [&](const Frame& frame, FrameStatus status) {
      if (status == FrameStatus::Used) {
        const RefinedMotion& refined = detector.refinedMotion();
        for (const Frame& other : seen) {
          if (other.stamp != refined.reference_stamp) continue;
          const SE2 odometry = other.T_odom_base.inverse() * frame.T_odom_base;
          worst = std::max(worst, std::abs(odometry.theta - refined.motion.theta));
          ++compared;
        }
      }
      seen.push_back(frame);
    });
    EXPECT_GT(compared, 10);
    return worst;
  }
};

TEST_F(LateDetector, GoesOnWithWhatItHasLearnt) {
  const auto right = drive(0.0, test::patientCalibration());
  EXPECT_EQ(right->timeOffset(), 0.0) << "nothing is moved without need";
  CalibrationParameters off = test::patientCalibration();
  off.learn_time_offset = false;
  const auto unaware = drive(0.08, off), aware = drive(0.08, test::patientCalibration());
  EXPECT_NEAR(aware->timeOffset(), -0.08, 0.006);
  for (SweepDetector* detector : {right.get(), unaware.get(), aware.get()}) detector->reset();
  EXPECT_NEAR(aware->timeOffset(), -0.08, 0.006) << "clocks and poses may jump";
  const double best = worstMotion(*right, 0.0), worst = worstMotion(*unaware, 0.08);
  ASSERT_GT(worst, 10.0 * best) << "the drive shows what late stamps do";
  EXPECT_LT(worstMotion(*aware, 0.08), 0.1 * worst);
}

/// What was chained up with stamps that were off leads elsewhere: the search for the floor's motion
/// must not begin there.
TEST_F(LateDetector, FollowsTheFloorFromTheMomentStampsAreMoved) {
  SweepDetector detector(test::smallParameters(), test::patientCalibration());
  detector.setCamera(test::smallCamera(), test::smallCameraPose());
  std::vector<Frame> seen;
  int compared = 0;
  LateImages(0.08).drive(detector, [&](const Frame& frame, FrameStatus status) {
    const RefinedMotion& refined = detector.refinedMotion();
    for (const Frame& other : seen) {
      if (status != FrameStatus::Used || other.stamp != refined.reference_stamp) continue;
      if (std::abs(frame.time_offset + 0.08) > 0.01) continue;
      const SE2 truth = swing().at(frame_period * static_cast<double>(other.index)).inverse() *
                        swing().at(frame_period * static_cast<double>(frame.index));
      EXPECT_NEAR(refined.motion.theta, truth.theta, 0.003) << "frame " << frame.index;
      EXPECT_NEAR(refined.motion.x, truth.x, 0.003) << "frame " << frame.index;
      compared += other.time_offset != frame.time_offset;
    }
    seen.push_back(frame);
  });
  EXPECT_GT(compared, 2) << "across the change";
}

TEST_F(LateDetector, PassesItOnToADetectorOfTheSameCamera) {
  const auto learnt = drive(0.08, test::patientCalibration());
  SweepParameters changed = test::smallParameters();
  changed.grid.max_range = 1.5;
  SweepDetector next(changed, test::patientCalibration());
  ASSERT_TRUE(next.adopt(*learnt));
  EXPECT_EQ(next.timeOffset(), learnt->timeOffset());
  CalibrationParameters off = test::patientCalibration();
  off.learn_time_offset = false;
  SweepDetector other(test::smallParameters(), off);
  ASSERT_TRUE(other.adopt(*learnt));
  EXPECT_EQ(other.timeOffset(), 0.0);
}

/// A clock belongs to the camera, wherever that is mounted.
TEST_F(LateDetector, ForgetsItWithTheCameraOnly) {
  const auto detector = drive(0.08, test::patientCalibration());
  const double before = detector->timeOffset();
  const CalibrationReport::Value learnt = detector->calibration()->time_offset;
  for (const double pitch : {0.5, 0.45}) {
    detector->setCamera(test::smallCamera(), test::smallCameraPose(pitch));
    EXPECT_EQ(detector->timeOffset(), before);
    const CalibrationReport r = *detector->calibration();
    EXPECT_EQ(r.pairs, 0);
    EXPECT_NEAR(r.time_offset.estimate, learnt.estimate, 1e-6);
    EXPECT_NEAR(r.time_offset.sigma, learnt.sigma, 1e-6);
    EXPECT_EQ(r.pitch.off(), 0.0);
  }
  detector->setCamera(test::smallCamera({}), test::smallCameraPose());
  EXPECT_EQ(detector->timeOffset(), 0.0);
  EXPECT_EQ(detector->calibration()->time_offset.estimate, 0.0);
}

TEST_F(LateDetector, LearnsNothingWhereThatIsNotWanted) {
  CalibrationParameters p = test::patientCalibration();
  p.learn_time_offset = false;
  EXPECT_EQ(drive(0.08, p)->timeOffset(), 0.0);
  EXPECT_NEAR(drive(0.08, p)->calibration()->time_offset.estimate, 0.0, 1e-4);
  p.learn_time_offset = true;
  p.mode = CalibrationMode::Off;
  EXPECT_EQ(drive(0.08, p)->timeOffset(), 0.0);
}

TEST_F(LateDetector, MovesNothingFartherThanIsAllowed) {
  CalibrationParameters p = test::patientCalibration();
  p.max_time_offset = 0.05;
  const auto detector = drive(0.08, p);
  EXPECT_EQ(detector->timeOffset(), -0.05);
  p.max_time_offset = 0.03;
  SweepDetector next(test::smallParameters(), p);
  ASSERT_TRUE(next.adopt(*detector));
  EXPECT_EQ(next.timeOffset(), -0.03);
}

}  // namespace
}  // namespace ipm_mapping::sweep
