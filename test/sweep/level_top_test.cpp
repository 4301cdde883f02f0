#include "ipm_mapping/sweep/level_top.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double face = 1.6;  // x of it
constexpr double way = 0.4;   // driven towards it

struct Seen {
  std::size_t contacts = 0;  // on the face
  std::size_t elsewhere = 0;
  std::size_t on_top = 0;       // of these, more than 10 cm behind the face
  std::size_t free_beyond = 0;  // bearings towards the face that promise floor behind it
  std::size_t free = 0;
};

test::GrainedScene slab(double height, double depth) {
  test::GrainedScene scene(test::smallCamera(), test::smallCameraPose());
  scene.boxes = {{face, face + depth, -0.3, 0.3, height}};
  return scene;
}

/// The last answer about a slab `height` high and `depth` deep.
Obstacles answer(double height, double depth, const SweepParameters& parameters) {
  return test::answerAfter(slab(height, depth), parameters, way);
}

Seen see(const Obstacles& obstacles) {
  Seen seen;
  for (const Contact& contact : obstacles.contacts) {
    const double off = way + static_cast<double>(contact.p_base.x()) - face;
    ++(std::abs(off) < 0.03 ? seen.contacts : seen.elsewhere);
    if (off > 0.1) ++seen.on_top;
  }
  const Eigen::Vector2d foot = obstacles.view.cameraFoot();
  for (const Bearing& bearing : obstacles.bearings) {
    if (bearing.state != BearingState::Free) continue;
    ++seen.free;
    const double range = (face - way - foot.x()) / std::cos(double{bearing.angle});
    const bool towards = std::abs(range * std::sin(double{bearing.angle}) + foot.y()) < 0.28;
    if (towards && bearing.range > range + 0.1) ++seen.free_beyond;
  }
  return seen;
}

SweepParameters topsFrom(double length) {
  SweepParameters p = test::smallParameters();
  p.selection.top_length = length;
  return p;
}

Seen see(double height, double depth, const SweepParameters& parameters) {
  return see(answer(height, depth, parameters));
}

TEST(LevelTop, ALowSlabIsFoundByItsTop) {
  const Seen by_face = see(0.03, 0.5, topsFrom(0.0)),
             by_top = see(0.03, 0.5, test::smallParameters());
  EXPECT_LE(by_face.contacts, 4U);
  EXPECT_GE(by_top.contacts, 12U);
  EXPECT_EQ(by_top.free_beyond, 0U);
}

/// A patch of the top looks upright too, somewhere behind the face.
TEST(LevelTop, AContactIsInFrontOfTheTopNotOnIt) {
  for (const double height : {0.025, 0.03}) {
    const Seen seen = see(height, 0.5, test::smallParameters());
    EXPECT_GE(seen.contacts, 2 * seen.elsewhere) << height;
    EXPECT_LE(seen.on_top, 1U) << height;
  }
}

/// Maxima beside each other are lifted once, not by each other's evidence.
TEST(LevelTop, NoScoreIsMoreThanWhatTheFloorAndTheTopSay) {
  float most = 0.0F;
  for (const double height : {0.025, 0.03})
    for (const Contact& contact : answer(height, 0.5, test::smallParameters()).contacts)
      most = std::max(most, contact.score);
  EXPECT_GT(most, 15.0F);
  EXPECT_LT(most, 80.0F);
}

TEST(LevelTop, AShortTopSaysNothing) {
  const Seen by_face = see(0.03, 0.05, topsFrom(0.0));
  const Seen by_top = see(0.03, 0.05, test::smallParameters());
  EXPECT_EQ(by_top.contacts, by_face.contacts);
}

TEST(LevelTop, WhatIsTooLowToBeAnObstacleHasNone) {
  SweepParameters by_face = topsFrom(0.0), by_top = test::smallParameters();
  by_face.selection.least_height = by_top.selection.least_height = 0.05;
  EXPECT_EQ(answer(0.03, 0.5, by_top).candidates.size(),
            answer(0.03, 0.5, by_face).candidates.size());
}

/// The floor looks raised then as well.
TEST(LevelTop, IsNotLookedForWhereThePoseIsKnownToBeStatedTooFlat) {
  const test::GrainedScene scene = slab(0.03, 0.5);
  CalibrationParameters off, report;
  off.mode = CalibrationMode::Off;
  report.row_step = 5;
  report.line_step = 7;
  const auto contacts = [&](double top_length, const CalibrationParameters& p, double too_flat) {
    return test::answerAfter(scene, topsFrom(top_length), way, p, too_flat).contacts.size();
  };
  constexpr double tilt = 0.7 * M_PI / 180.0;
  const double length = test::smallParameters().selection.top_length;
  const std::size_t by_face = contacts(0.0, off, tilt);
  EXPECT_EQ(contacts(length, report, tilt), by_face);
  EXPECT_GE(contacts(length, off, tilt), by_face + 3);
  EXPECT_EQ(contacts(length, report, -tilt), contacts(length, off, -tilt));
}

/// A share of what it takes to be published is enough for floor not to be promised.
TEST(DoubtfulCandidate, HasNoFreeFloorBehindIt) {
  const SweepParameters p = test::smallParameters();
  const Obstacles obstacles = answer(0.012, 0.1, p);
  const Eigen::Vector2f foot = obstacles.view.cameraFoot().cast<float>();
  int compared = 0;
  for (const Contact& c : obstacles.candidates) {
    const float d = (c.p_base - foot).norm();
    const double least = std::max(p.selection.publish_score, p.selection.publish_slope * 0.45 / d);
    const Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(c.bearing)];
    if (c.score < p.selection.weak_share * least || bearing.state != BearingState::Free) continue;
    EXPECT_LE(bearing.range, d + 0.01F);
    ++compared;
  }
  EXPECT_GE(compared, 3);
}

TEST(LevelTop, BareFloorStaysFree) {
  const Seen seen = see(0.0, 0.1, test::smallParameters());
  EXPECT_EQ(seen.contacts + seen.elsewhere, 0U);
  EXPECT_GT(seen.free, 40U);
  EXPECT_EQ(seen.free, see(0.0, 0.1, topsFrom(0.0)).free);
}

}  // namespace
}  // namespace ipm_mapping::sweep
