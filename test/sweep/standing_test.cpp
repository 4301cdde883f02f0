#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sweep/drive.hpp"

namespace ipm_mapping::sweep {
namespace {

using test::GrainedScene;

/// A robot that has driven up to something, or nothing, and stands.
class Standing : public ::testing::Test {
 protected:
  void start(const SweepParameters& parameters = test::smallParameters()) {
    drive = std::make_unique<test::Drive>(parameters);
  }
  void arrive() {
    ASSERT_EQ(drive->along(0.0, end, 20), FrameStatus::Used);
    used = drive->obstacles;
    rest();
  }
  /// The next frame is one of a robot that stands.
  void rest() { drive->index += 2; }
  FrameStatus stand(double seconds = 0.1) {
    drive->index += static_cast<std::uint64_t>(std::lround(seconds / 0.1)) - 1;
    return drive->at({end, 0.0, heading});
  }
  [[nodiscard]] int moving() const {
    const auto& contacts = drive->obstacles.contacts;
    return static_cast<int>(
        std::count_if(contacts.begin(), contacts.end(), [](const Contact& c) { return c.moving; }));
  }
  /// How far the middle of the view is free or occupied, metres from base.
  [[nodiscard]] const Bearing& ahead() const {
    const auto& all = drive->obstacles.bearings;
    return *std::min_element(all.begin(), all.end(), [](const Bearing& a, const Bearing& b) {
      return std::abs(a.angle) < std::abs(b.angle);
    });
  }
  [[nodiscard]] double reach() const {
    return double{ahead().range} + drive->scene.T_base_camera.translation().x();
  }

  double end = 0.5;
  double heading = 0.0;
  std::unique_ptr<test::Drive> drive;
  Obstacles used;  // answer on arriving
};

TEST_F(Standing, GoesOnSeeingWhatStandsThere) {
  start();
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  ASSERT_GT(used.contacts.size(), 10U);
  float age = 0.0F;
  for (int k = 0; k < 30; ++k) {
    ASSERT_EQ(stand(), FrameStatus::Watched);
    const Obstacles& now = drive->obstacles;
    EXPECT_GT(now.age, age) << "nothing new for a map";
    age = now.age;
    EXPECT_NEAR(static_cast<double>(age), 0.2 + 0.1 * (k + 1), 1e-4);
    EXPECT_GE(now.contacts.size() + 2, used.contacts.size());
    EXPECT_GT(drive->shareOnOutlines(), 0.95);
    for (const Contact& c : now.contacts) EXPECT_EQ(c.age, 0.0F) << "seen in this frame";
  }
}

TEST_F(Standing, SeesSomebodyComeStayAndLeave) {
  start();
  arrive();
  ASSERT_TRUE(used.contacts.empty());
  const double open = reach();
  for (int k = 0; k < 60; ++k) {
    const double y = std::min(-1.0 + 0.1 * k, -0.1);  // from the right, and stays
    drive->scene.boxes = {{1.6, 1.75, y, y + 0.25, 0.9}};
    ASSERT_EQ(stand(), FrameStatus::Watched);
    if (k < 10) continue;
    EXPECT_GE(moving(), 4) << k;
    EXPECT_GT(drive->shareOnOutlines(), 0.8) << k;
    EXPECT_EQ(ahead().state, BearingState::Occupied) << k;
    EXPECT_NEAR(reach(), 1.6 - end, 0.06) << k;
  }
  drive->scene.boxes.clear();
  ASSERT_EQ(stand(), FrameStatus::Watched);
  EXPECT_TRUE(drive->obstacles.contacts.empty());
  EXPECT_EQ(ahead().state, BearingState::Free) << "who waits for him may drive on";
  EXPECT_NEAR(reach(), open, 0.05);
}

TEST_F(Standing, SomebodyWhoHasBeenThereAllTheTimeLeavesNoGhost) {
  start();
  drive->scene.boxes = {{1.3, 1.45, -0.25, 0.3, 0.9}};
  arrive();
  ASSERT_GT(used.contacts.size(), 10U);
  drive->scene.boxes.clear();
  for (int k = 0; k < 10; ++k) {
    ASSERT_EQ(stand(0.2), FrameStatus::Watched);
    EXPECT_EQ(moving(), 0) << k;
    EXPECT_NE(ahead().state, BearingState::Occupied) << k;
  }
  // nor later, where his place lies below the view
  for (; end < 1.3; end += 0.05) {
    drive->at({end, 0.0, 0.0});
    EXPECT_NE(ahead().state, BearingState::Blocked) << end;
  }
}

TEST_F(Standing, LooksOnOnlyForSoLong) {
  SweepParameters parameters = test::smallParameters();
  parameters.reference.watch = 20.0;
  start(parameters);
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  ASSERT_EQ(stand(19.9), FrameStatus::Watched);
  EXPECT_FALSE(drive->obstacles.contacts.empty());
  ASSERT_EQ(stand(0.2), FrameStatus::NoMotion);
  EXPECT_TRUE(drive->obstacles.contacts.empty());
  EXPECT_TRUE(drive->obstacles.bearings.empty());
}

TEST_F(Standing, DoesNotLookOnWhereThatIsNotAskedFor) {
  SweepParameters parameters = test::smallParameters();
  parameters.reference.watch = 0.0;
  start(parameters);
  arrive();
  EXPECT_EQ(stand(), FrameStatus::NoMotion);
}

/// However long it stood: its references are as good as they were.
TEST_F(Standing, AnswersAtOnceWhenItDrivesOn) {
  for (const double watch : {300.0, 0.0}) {
    SweepParameters parameters = test::smallParameters();
    parameters.reference.watch = watch;
    start(parameters);
    drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
    arrive();
    const double seconds = parameters.reference.max_age + 20.0;
    for (double t = 0.0; t < seconds; t += 1.0) stand(1.0);
    const FrameStatus status = drive->at({end + 0.025, 0.0, 0.0});
    EXPECT_EQ(status, watch > 0.0 ? FrameStatus::Used : FrameStatus::NoReference);
    if (watch > 0.0) {
      EXPECT_GT(drive->obstacles.contacts.size(), 10U);
      EXPECT_EQ(drive->obstacles.age, 0.0F);
    }
  }
}

/// Nor do several stops on the way add up.
TEST_F(Standing, StopsAgain) {
  start();
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  for (int stop = 0; stop < 3; ++stop) {
    for (double t = 0.0; t < 10.0; t += 1.0) ASSERT_EQ(stand(1.0), FrameStatus::Watched) << stop;
    end += 0.025;
    ASSERT_EQ(stand(), FrameStatus::Used) << stop;
    rest();
  }
}

TEST_F(Standing, DoesNotForgetWhatStandsBelowTheView) {
  start();
  end = 0.85;
  drive->scene.boxes = {{1.1, 1.14, -0.3, 0.3, 0.1}};
  ASSERT_EQ(drive->along(0.0, end, 34), FrameStatus::Used);
  ASSERT_EQ(ahead().state, BearingState::Blocked);
  rest();
  for (int k = 0; k < 6; ++k) {
    ASSERT_EQ(stand(10.0), FrameStatus::Watched);
    EXPECT_EQ(ahead().state, BearingState::Blocked) << k;
  }
}

/// What is seen again and again out of the same views has not been seen twice.
TEST_F(Standing, DoesNotComeToBelieveALoneContact) {
  for (const int frames : {1, 16}) {
    SweepParameters parameters = test::smallParameters();
    parameters.selection.lone_frames = parameters.selection.lone_of = frames;
    parameters.moving.moving_score = 0.0;
    start(parameters);
    drive->scene.boxes = {{1.4, 1.42, -0.012, 0.012, 0.9}};
    ASSERT_EQ(drive->along(0.35, end, 12), FrameStatus::Used);
    rest();
    int seen = 0;
    for (int k = 0; k < 20; ++k) {
      ASSERT_EQ(stand(), FrameStatus::Watched);
      seen += drive->obstacles.contacts.empty() ? 0 : 1;
    }
    EXPECT_EQ(seen, frames == 1 ? 20 : 0);
  }
}

/// Driving so slowly that every other frame has not moved is not standing.
TEST_F(Standing, WhatADrivingRobotSawGrowsOld) {
  SweepParameters parameters = test::smallParameters();
  parameters.reference.max_age = 3.0;
  start(parameters);
  ASSERT_EQ(drive->along(0.0, end, 20), FrameStatus::Used);
  FrameStatus status = FrameStatus::Used;
  double x = end;
  int still = 0;
  for (int k = 0; k < 80; ++k) {
    status = drive->at({x += 0.00125, 0.0, 0.0});
    EXPECT_NE(status, FrameStatus::Watched) << k;
    still += status == FrameStatus::NoMotion ? 1 : 0;
  }
  EXPECT_NEAR(still, 40, 1);
  EXPECT_EQ(status, FrameStatus::NoReference) << "ten centimetres in eight seconds";
}

/// Nor does odometry go wrong while it stands still.
TEST_F(Standing, KnowsTheMotionSinceItsReferencesAsWellAsBefore) {
  SweepParameters parameters = test::smallParameters();
  parameters.refinement.correlation = 1e-6;  // odometry leads
  start(parameters);
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  const Eigen::Matrix3d before = drive->detector.refinedMotion(0).covariance;
  ASSERT_EQ(stand(200.0), FrameStatus::Watched);
  const Eigen::Matrix3d after = drive->detector.refinedMotion(0).covariance;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(after(i, i), before(i, i), 0.2 * before(i, i)) << i;
}

TEST_F(Standing, LooksAroundAndKnowsWhereItCameFrom) {
  SweepParameters parameters = test::smallParameters();
  parameters.reference.history = 24;
  start(parameters);
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  for (const double far : {1.6, -1.6})
    for (int k = 0; k <= 80; ++k) {
      heading = far * (1.0 - std::abs(k - 40) / 40.0);
      stand();
    }
  ASSERT_EQ(stand(), FrameStatus::Watched);
  EXPECT_GT(drive->obstacles.contacts.size(), 10U);
  end += 0.025;
  EXPECT_EQ(stand(), FrameStatus::Used);
  EXPECT_GT(drive->shareOnOutlines(), 0.95);
}

/// Wheels do not tell that somebody has pushed the robot. It sees that nothing is where it was.
TEST_F(Standing, SaysNothingWhereItHasBeenPushed) {
  start();
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  const SE2 here{end, 0.0, 0.0};
  for (const SE2& push : {SE2{0.0, 0.0, 0.1}, SE2{0.1, 0.05, 0.1}, SE2{-0.2, 0.1, 0.3}}) {
    EXPECT_EQ(drive->at(here * push, here), FrameStatus::NoMotion) << push.theta;
    EXPECT_TRUE(drive->obstacles.bearings.empty());
    EXPECT_TRUE(drive->obstacles.contacts.empty());
  }
  EXPECT_EQ(stand(), FrameStatus::Watched) << "and is back";
  EXPECT_GT(drive->shareOnOutlines(), 0.95);
}

TEST_F(Standing, DoesNotMindTheLight) {
  start();
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  for (const double light : {0.6, 0.8, 1.3}) {
    drive->light = light;
    ASSERT_EQ(stand(), FrameStatus::Watched) << light;
    EXPECT_GE(drive->obstacles.contacts.size() + 2, used.contacts.size()) << light;
    EXPECT_EQ(moving(), 0) << light;
    EXPECT_GT(drive->shareOnOutlines(), 0.95) << light;
  }
  drive->light = 0.15;  // it has gone out
  EXPECT_EQ(stand(), FrameStatus::NoMotion);
  EXPECT_TRUE(drive->obstacles.contacts.empty());
}

TEST_F(Standing, TurnsItsHeadALittleAndStillSees) {
  start();
  drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
  arrive();
  for (heading = 0.0; heading < 0.3; heading += 0.04) {
    ASSERT_EQ(stand(), FrameStatus::Watched) << heading;
    EXPECT_GT(drive->obstacles.contacts.size(), 8U) << heading;
    EXPECT_GT(drive->shareOnOutlines(), 0.9) << heading;
  }
  heading = 0.6;
  EXPECT_EQ(stand(), FrameStatus::NoMotion);
}

TEST_F(Standing, WithoutAWayBehindItThereIsNothingToCompareWith) {
  start();
  ASSERT_EQ(drive->at({0.0, 0.0, 0.0}), FrameStatus::NoReference);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(drive->at({0.0, 0.0, 0.0}), FrameStatus::NoMotion);
}

}  // namespace
}  // namespace ipm_mapping::sweep
