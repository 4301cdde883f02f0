#include "ipm_mapping/sweep/sweep_detector.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/parameters/visitors.hpp"
#include "kernels/sweep_targets.hpp"
#include "sweep/drive.hpp"

namespace ipm_mapping::sweep {
namespace {

using test::Drive;

TEST(SweepDetector, FindsTheFrontOfABoxAndNothingElse) {
  Drive drive;
  drive.scene.boxes = {{1.25, 1.5, -0.2, 0.25, 0.4}};
  ASSERT_EQ(drive.along(0.0, 0.4, 5), FrameStatus::Used);
  EXPECT_GE(drive.obstacles.contacts.size(), 5U);
  EXPECT_GE(drive.shareOnOutlines(), 0.99);
}

TEST(SweepDetector, FindsItWithALevelCameraToo) {
  Drive drive(test::smallParameters(), 0.0);
  drive.scene.boxes = {{1.6, 1.9, -0.3, 0.35, 0.5}};
  ASSERT_EQ(drive.along(0.0, 0.4, 5), FrameStatus::Used);
  EXPECT_GE(drive.obstacles.contacts.size(), 4U);
  EXPECT_GE(drive.shareOnOutlines(), 0.75);
}

TEST(SweepDetector, FindsItWhileReversing) {
  Drive drive;
  drive.scene.boxes = {{1.3, 1.5, -0.2, 0.25, 0.4}};
  ASSERT_EQ(drive.along(0.4, 0.0, 5), FrameStatus::Used);
  EXPECT_GE(drive.obstacles.contacts.size(), 4U);
  EXPECT_GE(drive.shareOnOutlines(), 0.95);
}

/// A post a beam wide: known from the second look on, and its bearing never free.
TEST(SweepDetector, AThinPostIsBelievedAtTheSecondLook) {
  Drive drive;
  drive.scene.boxes = {{1.25, 1.28, 0.0, 0.025, 0.5}};
  int looks = 0;
  std::size_t first = 0, later = 0;
  for (int i = 0; i <= 6; ++i) {
    if (drive.at({0.05 * i, 0.0, 0.0}) != FrameStatus::Used) continue;
    (looks++ == 0 ? first : later) += drive.obstacles.contacts.size();
    const Eigen::Vector2d foot = drive.last * Eigen::Vector2d(0.05, -0.01);
    for (const Bearing& b : drive.obstacles.bearings)
      if (b.state == BearingState::Free &&
          std::abs(double{b.angle} - std::atan2(0.006 - foot.y(), 1.25 - foot.x())) < 0.005) {
        EXPECT_LT(b.range, 1.3 - foot.x());
      }
  }
  EXPECT_EQ(first, 0U);
  EXPECT_GT(later, 0U);
}

/// A robot drives over a mat or a cable, not over a plank.
TEST(SweepDetector, WhatIsTooLowIsNoObstacleAndNoFreeFloorEither) {
  for (const double height : {0.012, 0.05}) {
    SweepParameters parameters = test::smallParameters();
    parameters.selection.least_height = 0.03;
    Drive drive(parameters);
    drive.scene.boxes = {{0.95, 1.15, -0.2, 0.25, height}};
    ASSERT_EQ(drive.along(0.0, 0.3, 5), FrameStatus::Used);
    if (height > 0.03) {
      EXPECT_GE(drive.obstacles.contacts.size(), 5U);
    } else {
      EXPECT_TRUE(drive.obstacles.contacts.empty());
      parameters.selection.least_height = 0.0;
      parameters.selection.top_length = 0.0;
      Drive by_face(parameters);
      by_face.scene.boxes = drive.scene.boxes;
      ASSERT_EQ(by_face.along(0.0, 0.3, 5), FrameStatus::Used);
      EXPECT_GE(by_face.obstacles.contacts.size(), 2U);
      for (const Contact& c : by_face.obstacles.contacts)
        EXPECT_NE(drive.obstacles.bearings[static_cast<std::size_t>(c.bearing)].state,
                  BearingState::Free);
      parameters.selection.top_length = test::smallParameters().selection.top_length;
      Drive all(parameters);
      all.scene.boxes = drive.scene.boxes;
      ASSERT_EQ(all.along(0.0, 0.3, 5), FrameStatus::Used);
      EXPECT_GE(all.obstacles.contacts.size(), 2U);
      const Eigen::Vector2f foot = all.obstacles.view.cameraFoot().cast<float>();
      for (const Contact& c : all.obstacles.contacts) {
        const Bearing& b = drive.obstacles.bearings[static_cast<std::size_t>(c.bearing)];
        if (b.state == BearingState::Free) {
          EXPECT_LT(b.range, (c.p_base - foot).norm() + 0.03F);
        }
      }
    }
  }
}

/// A low block, seen from 0.8 m to half a metre; what a detector with the same parameters knows of
/// it where the view begins behind its place.
class BelowTheView : public ::testing::Test {
 protected:
  void see(const SweepParameters& parameters) {
    before = std::make_unique<Drive>(parameters);
    before->scene.boxes = {{1.0, 1.1, -0.4, 0.4, 0.2}};
    before->at({0.0, 0.0, 0.0});
    before->at({0.2, 0.0, 0.0});
    for (double t = 0.0; t < stood; t += 1.0) {
      before->index += 9;
      before->at({0.2, 0.0, 0.0});
    }
    ASSERT_EQ(before->along(0.2, 0.45, 5), FrameStatus::Used);
    now = std::make_unique<Drive>(parameters);
    now->index = before->index;
  }
  [[nodiscard]] int blockedAhead() const {
    EXPECT_EQ(now->along(0.45, 0.65, 4), FrameStatus::Used);
    EXPECT_TRUE(now->obstacles.contacts.empty());
    const auto& bearings = now->obstacles.bearings;
    return static_cast<int>(std::count_if(bearings.begin(), bearings.end(), [](const Bearing& b) {
      return b.state == BearingState::Blocked && std::abs(b.angle) < 0.3F;
    }));
  }
  std::unique_ptr<Drive> before, now;
  double stood = 0.0;  // seconds, on the way
};

TEST_F(BelowTheView, ADetectorWithOtherParametersRemembers) {
  see(test::smallParameters());
  EXPECT_EQ(blockedAhead(), 0);
  see(test::smallParameters());
  ASSERT_TRUE(now->detector.adopt(before->detector));
  EXPECT_GE(blockedAhead(), 5);
}

/// Its clock does not count while it stands.
TEST_F(BelowTheView, NorIsItForgottenByOneThatHasStood) {
  for (const double seconds : {0.0, 60.0}) {
    stood = seconds;
    see(test::smallParameters());
    ASSERT_TRUE(now->detector.adopt(before->detector));
    EXPECT_GE(blockedAhead(), 5) << seconds;
  }
}

/// What is withdrawn from the answer does not come back from memory.
TEST_F(BelowTheView, WhatIsDoubtfulIsNotRemembered) {
  SweepParameters parameters = test::smallParameters();
  parameters.selection.least_height = 0.4;
  see(parameters);
  ASSERT_TRUE(now->detector.adopt(before->detector));
  EXPECT_EQ(blockedAhead(), 0);
}

TEST(SweepDetector, WithoutACameraThereIsNothingToTakeOver) {
  EXPECT_FALSE(SweepDetector().adopt(SweepDetector()));
}

/// A robot that nods a third of a degree from frame to frame.
TEST(SweepDetector, NoddingDoesNotMakeObstaclesOfTheFloor) {
  Drive drive;
  drive.scene.boxes = {{1.25, 1.5, -0.2, 0.25, 0.4}};
  int frames = 0;
  for (int i = 0; i <= 6; ++i) {
    drive.sway.pitch = i % 2 == 0 ? 0.003 : -0.003;
    if (drive.at({0.07 * i, 0.0, 0.0}) != FrameStatus::Used) continue;
    ++frames;
    EXPECT_GE(drive.obstacles.contacts.size(), 5U);
    EXPECT_GE(drive.shareOnOutlines(), 0.95) << i;
  }
  EXPECT_GE(frames, 3);
}

/// Without the sway a reference shows less of the floor: a strip at the end of the view is made up.
TEST(SweepDetector, ANoddingRobotComparesOnlyWhatBothFramesSaw) {
  const auto compared = [](double pitch) {
    Drive drive;
    drive.at({0.0, 0.0, 0.0});
    drive.sway.pitch = pitch;
    EXPECT_EQ(drive.at({0.16, 0.0, 0.0}), FrameStatus::Used);
    EXPECT_NEAR(std::abs(drive.detector.refinedMotion().sway.pitch), std::abs(pitch), 0.001);
    const auto residual = drive.detector.residual();
    return std::count_if(residual.data, residual.row(residual.height),
                         [](std::int16_t e) { return e != kernels::no_residual; });
  };
  // Driving forward it is the far end that counts: it is lost when the robot nods one way.
  EXPECT_LT(std::min(compared(0.006), compared(-0.006)), compared(0.0));
}

TEST(SweepDetector, AnEmptyFloorIsFreeAndHasNoContacts) {
  Drive drive;
  ASSERT_EQ(drive.along(0.0, 0.4, 5), FrameStatus::Used);
  EXPECT_TRUE(drive.obstacles.contacts.empty());
  int free = 0;
  for (const Bearing& b : drive.obstacles.bearings) {
    EXPECT_NE(b.state, BearingState::Occupied);
    EXPECT_NE(b.state, BearingState::Blocked);
    free += b.state == BearingState::Free && b.range > 1.0F;
  }
  EXPECT_GT(free, static_cast<int>(drive.obstacles.bearings.size()) / 4);
}

TEST(SweepDetector, FloorBehindAnObstacleIsNeverFree) {
  Drive drive;
  drive.scene.boxes = {{1.0, 1.3, -0.25, 0.25, 0.4}};
  ASSERT_EQ(drive.along(0.0, 0.32, 4), FrameStatus::Used);
  const Eigen::Vector2d foot = drive.scene.T_base_camera.translation().head<2>();
  for (const Bearing& b : drive.obstacles.bearings) {
    const double y = (0.68 - foot.x()) * std::tan(static_cast<double>(b.angle)) + foot.y();
    if (std::abs(y) > 0.2 || b.state != BearingState::Free) continue;
    EXPECT_LT(b.range, (0.68 - foot.x()) / std::cos(static_cast<double>(b.angle)) + 0.05);
  }
}

TEST(SweepDetector, BearingsRunFromLeftToRightAndContactsPointToTheirs) {
  Drive drive;
  drive.scene.boxes = {{1.25, 1.5, -0.2, 0.25, 0.4}};
  ASSERT_EQ(drive.along(0.0, 0.4, 5), FrameStatus::Used);
  const auto& bearings = drive.obstacles.bearings;
  for (std::size_t i = 1; i < bearings.size(); ++i)
    EXPECT_LT(bearings[i].angle, bearings[i - 1].angle);
  const Eigen::Vector2d foot = drive.scene.T_base_camera.translation().head<2>();
  const GroundProjection floor = drive.obstacles.view.currentFloor();
  for (const Contact& c : drive.obstacles.contacts) {
    const Bearing& b = bearings[static_cast<std::size_t>(c.bearing)];
    const Eigen::Vector2d seen = c.p_base.cast<double>() - foot;
    EXPECT_EQ(b.state, BearingState::Occupied);
    EXPECT_NEAR(std::atan2(seen.y(), seen.x()), static_cast<double>(b.angle), 1e-5);
    EXPECT_NEAR(seen.norm(), static_cast<double>(b.range), 1e-5);
    const auto pixel = floor.pixel(c.p_base.cast<double>());
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), static_cast<double>(c.u), 0.01);
    EXPECT_NEAR(pixel->y(), static_cast<double>(c.v), 0.01);
    EXPECT_GT(c.range_sigma, 0.0F);
    EXPECT_GT(c.height, 0.0F);
    EXPECT_LT(c.height, 0.45F);
  }
}

/// A camera that was dazzled for two tenths of a metre has references that show nothing.
class Dazzled : public ::testing::Test {
 protected:
  /// Drives 40 cm up to a box, or back from it.
  void arrive(const SweepParameters& parameters = test::smallParameters(), double way = 0.4) {
    drive = std::make_unique<Drive>(parameters);
    drive->scene.boxes = {{1.7, 1.85, -0.25, 0.3, 0.4}};
    step = way / 20;
    drive->along(0.0, x = way, 20);
    ASSERT_GT(drive->obstacles.contacts.size(), 10U);
    last_seen = drive->obstacles.view.stamp;
  }
  void dazzle(double share = 1.0) {
    drive->dazzled = share;
    goOn(11);
    drive->dazzled = 0.0;
    goOn(5);
  }
  void goOn(int steps) {
    for (int k = 0; k < steps; ++k) drive->at({x += step, 0.0, 0.0});
  }
  [[nodiscard]] std::vector<Contact> held() const {
    std::vector<Contact> found;
    for (const Contact& c : drive->obstacles.contacts)
      if (c.age > 0.0F) found.push_back(c);
    return found;
  }
  [[nodiscard]] double sinceLastSeen() const { return drive->obstacles.view.stamp - last_seen; }

  std::unique_ptr<Drive> drive;
  double x = 0.0, step = 0.0;
  double last_seen = 0.0;
};

TEST_F(Dazzled, HoldsWhatStoodThereWithItsAge) {
  arrive();
  dazzle();
  const Obstacles& now = drive->obstacles;
  ASSERT_GT(held().size(), 10U);
  EXPECT_EQ(now.age, 0.0F);
  for (const Contact& c : held()) {
    EXPECT_LT(drive->scene.distanceToOutline(drive->last * c.p_base.cast<double>()), 0.03);
    EXPECT_GE(double{c.age}, sinceLastSeen() - 1e-4);
    EXPECT_LE(double{c.age}, sinceLastSeen() + 1.0);
    const Bearing& bearing = now.bearings[static_cast<std::size_t>(c.bearing)];
    EXPECT_NE(bearing.state, BearingState::Occupied);
    EXPECT_LT(double{bearing.range}, (c.p_base.cast<double>() - now.view.cameraFoot()).norm());
    EXPECT_GT(c.height, 0.1F);
    EXPECT_GT(c.v, 100.0F);
  }
}

/// A box whose grain flickers shows neither itself nor floor.
TEST_F(Dazzled, WhatIsHeldChangesNothingOfWhatIsSaidOfTheFloor) {
  SweepParameters parameters = test::smallParameters();
  parameters.foot.foot_memory = 0.0;
  std::vector<Bearing> without;
  for (const int sights : {0, 2}) {
    parameters.foot.hold_sights = sights;
    arrive(parameters);
    drive->scene.wall_contrast = 60.0;
    for (int k = 1; k <= 14; ++k) {
      drive->scene.wall_shift = 0.37 * k;
      goOn(1);
    }
    const auto& now = drive->obstacles.bearings;
    if (sights == 0) {
      without = now;
      continue;
    }
    EXPECT_GT(held().size(), 10U);
    ASSERT_EQ(now.size(), without.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      EXPECT_EQ(now[i].state, without[i].state);
      EXPECT_EQ(now[i].range, without[i].range);
      EXPECT_EQ(now[i].near, without[i].near);
    }
  }
}

TEST_F(Dazzled, OnOneSideItSeesTheOtherAsEver) {
  arrive();
  dazzle(0.5);
  const auto& contacts = drive->obstacles.contacts;
  EXPECT_GT(held().size(), 4U);
  EXPECT_GT(contacts.size(), held().size() + 4);
  for (std::size_t k = 1; k < contacts.size(); ++k)
    EXPECT_LT(contacts[k - 1].bearing, contacts[k].bearing);
}

TEST_F(Dazzled, WhatAStandingRobotSawIsOfNoUse) {
  arrive();
  drive->index += 2;
  for (int k = 0; k < 30; ++k) ASSERT_EQ(drive->at({x, 0.0, 0.0}), FrameStatus::Watched);
  dazzle();
  ASSERT_GT(held().size(), 10U);
  for (const Contact& c : held()) EXPECT_GE(double{c.age}, sinceLastSeen() - 1e-4);
}

TEST_F(Dazzled, AfterAMinuteOfStandingItWaitsForANewSight) {
  arrive();
  drive->index += 600;
  ASSERT_EQ(drive->at({x, 0.0, 0.0}), FrameStatus::Watched);
  dazzle();
  EXPECT_TRUE(held().empty());
}

TEST_F(Dazzled, HoldsNothingFartherThanItLooks) {
  SweepParameters parameters = test::smallParameters();
  for (const double range : {2.3, 2.05}) {
    parameters.grid.max_range = range;
    arrive(parameters, -0.25);
    dazzle();
    EXPECT_EQ(held().empty(), range < 2.1) << range;
  }
}

TEST_F(Dazzled, HoldsNothingWhereThatIsNotAskedForOrAfterAReset) {
  SweepParameters parameters = test::smallParameters();
  parameters.foot.hold_sights = 0;
  arrive(parameters);
  dazzle();
  EXPECT_TRUE(held().empty());
  arrive();
  drive->detector.reset();
  dazzle(0.5);
  ASSERT_FALSE(drive->obstacles.bearings.empty());
  EXPECT_TRUE(held().empty());
}

TEST(SweepDetector, SaysWhyThereIsNoAnswer) {
  Drive drive;
  EXPECT_EQ(drive.at({0, 0, 0}), FrameStatus::NoReference);
  EXPECT_EQ(drive.at({0.0005, 0, 0}), FrameStatus::NoMotion);
  EXPECT_EQ(drive.at({0.2, 0, 0}), FrameStatus::Used);
  EXPECT_EQ(drive.at({0.2, 0, 0}), FrameStatus::NoMotion);
  EXPECT_TRUE(drive.obstacles.bearings.empty());
  drive.index += 2;  // it stands
  EXPECT_EQ(drive.at({0.2, 0, 0}), FrameStatus::Watched);
  EXPECT_FALSE(drive.obstacles.bearings.empty());
  EXPECT_EQ(drive.at({0.2, 0, 0.5}), FrameStatus::NoMotion);
  EXPECT_TRUE(drive.obstacles.bearings.empty());
  EXPECT_EQ(drive.at({0.4, 0, 1.0}), FrameStatus::TooMuchRotation);
  drive.detector.reset();
  EXPECT_EQ(drive.at({0.6, 0, 0}), FrameStatus::NoReference);
}

TEST(SweepDetector, AfterAResetItAnswersAsANewOne) {
  const auto scores = [](const Drive& drive) {
    std::vector<float> all;
    for (const Contact& c : drive.obstacles.contacts) {
      all.push_back(c.p_base.x());
      all.push_back(c.p_base.y());
      all.push_back(c.score);
    }
    for (const Bearing& b : drive.obstacles.bearings) all.push_back(b.range);
    return all;
  };
  Drive used, fresh;
  used.scene.boxes = {{0.95, 1.2, -0.5, 0.5, 0.4}};
  ASSERT_EQ(used.along(0.0, 0.4, 4), FrameStatus::Used);
  ASSERT_FALSE(used.obstacles.contacts.empty());
  used.detector.reset();
  for (Drive* drive : {&used, &fresh}) drive->scene.boxes = {{1.25, 1.5, -0.2, 0.25, 0.4}};
  ASSERT_EQ(used.along(0.0, 0.4, 2), FrameStatus::Used);
  ASSERT_EQ(fresh.along(0.0, 0.4, 2), FrameStatus::Used);
  EXPECT_EQ(scores(used), scores(fresh));
}

TEST(SweepDetector, ObstaclesDoNotMisleadTheMotionOfTheFirstAnswer) {
  Drive drive;
  drive.scene.boxes = {{0.75, 1.2, -0.35, 0.6, 0.4}};  // half of what it sees is not floor
  drive.at({0.0, 0.0, 0.0});
  ASSERT_EQ(drive.at({0.2, 0.0, 0.0}, {0.206, 0.0, 0.004}), FrameStatus::Used);
  EXPECT_NEAR(drive.detector.refinedMotion().motion.x, 0.2, 0.0015);
}

TEST(SweepDetector, RefusesImagesOfAnotherSizeAndAMissingCamera) {
  SweepDetector detector;
  Obstacles obstacles;
  Image<std::uint8_t> picture(100, 50);
  Frame frame;
  frame.image = picture.view();
  EXPECT_EQ(detector.process(frame, obstacles), FrameStatus::NoCamera);
  detector.setCamera(test::smallCamera(), test::smallCameraPose());
  EXPECT_EQ(detector.process(frame, obstacles), FrameStatus::SizeMismatch);
  detector.setCamera(test::smallCamera(), cameraPose(0, 0, 0.45, -0.8));
  Image<std::uint8_t> right(400, 300);
  frame.image = right.view();
  EXPECT_EQ(detector.process(frame, obstacles), FrameStatus::GeometryUnusable);
}

TEST(SweepDetector, TheAnswerIsTheSameOnEveryInstructionSet) {
  std::vector<float> first;
  test::withEverySweepTarget([&] {
    Drive drive;
    drive.scene.boxes = {{1.25, 1.5, -0.2, 0.25, 0.4}};
    ASSERT_EQ(drive.along(0.2, 0.4, 3), FrameStatus::Used);
    std::vector<float> answer;
    for (const Bearing& b : drive.obstacles.bearings) answer.push_back(b.range);
    for (const Contact& c : drive.obstacles.contacts) {
      answer.push_back(c.p_base.x());
      answer.push_back(c.score);
    }
    if (first.empty()) first = answer;
    EXPECT_EQ(answer, first);
  });
}

TEST(SweepDetector, RefinedMotionIsNearerTheTruthThanOdometry) {
  Drive drive;
  const Image<std::uint8_t> a = drive.scene.render({0, 0, 0});
  const Image<std::uint8_t> b = drive.scene.render({0.16, 0, 0});
  Frame frame;
  frame.image = a.view();
  ASSERT_EQ(drive.detector.process(frame, drive.obstacles), FrameStatus::NoReference);
  frame.image = b.view();
  frame.stamp = 0.1;
  frame.T_odom_base = {0.1635, 0.0, 0.001};
  ASSERT_EQ(drive.detector.process(frame, drive.obstacles), FrameStatus::Used);
  EXPECT_NEAR(drive.detector.refinedMotion().motion.x, 0.16, 0.001);
  EXPECT_DOUBLE_EQ(drive.obstacles.view.motion.x, drive.detector.refinedMotion().motion.x);
}

TEST(SweepParameters, EveryFieldHasANameOfItsOwnAndADefaultInsideItsRange) {
  SweepParameters parameters;
  std::set<std::string> names;
  forEachField(parameters, [&](const char* name, auto& value, Unit, Range range, const char* doc) {
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_TRUE(range.contains(static_cast<double>(value))) << name;
    EXPECT_GT(std::string(doc).size(), 10U) << name;
  });
  EXPECT_GT(names.size(), 50U);
}

}  // namespace
}  // namespace ipm_mapping::sweep
