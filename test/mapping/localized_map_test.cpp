// A robot whose odometry drifts drives along a wall of posts while a localiser corrects it: where
// do the posts stand in the map afterwards?

#include "ipm_mapping/mapping/localized_map.hpp"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

#include "mapping/support/map_frames.hpp"

namespace ipm_mapping {
namespace {

using namespace map_test;

/// Ten centimetres and three degrees.
const SE2 correction{0.08, 0.06, 0.0524};

std::vector<Eigen::Vector2d> posts() {
  std::vector<Eigen::Vector2d> all;
  for (int i = 0; i < 24; ++i) all.emplace_back(0.525 + 0.25 * i, i % 2 ? 0.625 : -0.575);
  return all;
}

/// What the robot sees from its true pose: the posts within 1.2 m, and free floor up to them.
Obstacles seenFrom(const SE2& T_world_base) {
  Obstacles frame = frameAt({});
  for (const Eigen::Vector2d& post : posts()) {
    const Eigen::Vector2d p = T_world_base.inverse() * post;
    if (p.norm() > 1.2 || p.x() < 0.1) continue;
    frame.contacts.push_back(contactAt(static_cast<float>(p.x()), static_cast<float>(p.y())));
    frame.bearings.push_back(bearing(BearingState::Occupied,
                                     static_cast<float>(std::atan2(p.y(), p.x())),
                                     static_cast<float>(p.norm())));
  }
  return frame;
}

/// Straight on, 5 cm a frame, between the lines of the cells.
SE2 truePose(int i) { return {0.013 + 0.05 * i, 0.017, 0.0}; }

void expectSameMap(const OccupancyMap& got, const OccupancyMap& expected) {
  TrinaryMap a, b;
  got.copyTo(a);
  expected.copyTo(b);
  EXPECT_EQ(std::tie(a.origin_x, a.origin_y, a.width, a.height),
            std::tie(b.origin_x, b.origin_y, b.width, b.height));
  EXPECT_TRUE(a.cells == b.cells);
}

struct Drive {
  OccupancyMap map{withUpdate(MapUpdate::LogOdds)};
  LocalizedMap localized;
  int corrections = 0;

  explicit Drive(MapCorrection kind, int frames = 200) : localized(map, kind, frames) {}
  void frame(int i, const SE2& T_odom_base, const SE2& T_map_odom) {
    Obstacles answer = seenFrom(truePose(i));
    answer.view.T_odom_base = T_odom_base;
    corrections += localized.update(answer, T_map_odom);
  }
  /// Farthest that an occupied cell's centre lies from a post; infinity when a post that came into
  /// view has no cell within 7 cm.
  [[nodiscard]] double farthest(double seen_up_to = 4.0) const {
    double worst = 0.0;
    std::vector<bool> found(posts().size(), false);
    const MapGeometry& g = map.geometry();
    for (int i = 0; i < g.width * g.height; ++i) {
      if (map.occupancy(static_cast<std::size_t>(i)) != 100) continue;
      const Eigen::Vector2d centre =
          0.05 * Eigen::Vector2d(g.first.x + i % g.width + 0.5, g.first.y + i / g.width + 0.5);
      double nearest = 1e9;
      for (std::size_t k = 0; k < found.size(); ++k) {
        const double d = (posts()[k] - centre).norm();
        nearest = std::min(nearest, d);
        if (d < 0.07) found[k] = true;
      }
      worst = std::max(worst, nearest);
    }
    for (std::size_t k = 0; k < found.size(); ++k)
      if (posts()[k].x() < seen_up_to && !found[k]) return 1e9;
    return worst;
  }
};

constexpr double half_diagonal = 0.0354;  // of a cell

TEST(LocalizedMap, FollowsALocaliserThatPutsTheWholeWayElsewhere) {
  // Odometry is right about the way; the localiser knew the start wrongly and mends it at frame 30.
  const auto drive = [](MapCorrection kind) {
    Drive d(kind);
    for (int i = 0; i < 60; ++i) d.frame(i, truePose(i), i < 30 ? correction : SE2{});
    EXPECT_EQ(d.corrections, 1);
    return d.farthest();
  };
  EXPECT_LT(drive(MapCorrection::Follow), half_diagonal + 1e-6);
  EXPECT_GT(drive(MapCorrection::Keep), 0.09) << "posts stand twice";
  EXPECT_GT(drive(MapCorrection::Spread), 0.06);
}

TEST(LocalizedMap, SpreadsWhatOdometryLostOnTheWay) {
  // The pose drifts evenly over 30 frames; then the localiser makes up for it.
  const auto drive = [](MapCorrection kind) {
    Drive d(kind);
    for (int i = 0; i < 60; ++i) {
      const SE2 drifted =
          interpolate(truePose(i), correction * truePose(i), std::min(i, 30) / 30.0);
      d.frame(i, drifted, i < 30 ? SE2{} : correction.inverse());
    }
    EXPECT_EQ(d.corrections, 1);
    return d.farthest();
  };
  EXPECT_LT(drive(MapCorrection::Spread), half_diagonal + 0.01);
  EXPECT_GT(drive(MapCorrection::Keep), 0.09);
  EXPECT_GT(drive(MapCorrection::Follow), 0.06);
}

TEST(LocalizedMap, OnlyTheStretchSinceTheLastCorrectionMoves) {
  // Two corrections: what was seen before the first one is right and has to stay when the second
  // one comes.
  Drive d(MapCorrection::Follow);
  for (int i = 0; i < 60; ++i)
    d.frame(i, truePose(i), i < 20 ? correction.inverse() : i < 40 ? SE2{} : correction);
  EXPECT_EQ(d.corrections, 2);
  Drive expected(MapCorrection::Keep);
  for (int i = 0; i < 20; ++i) expected.frame(i, truePose(i), SE2{});
  for (int i = 20; i < 60; ++i) expected.frame(i, truePose(i), correction);
  expectSameMap(d.map, expected.map);
}

TEST(LocalizedMap, WithoutCorrectionsItIsTheMapItself) {
  for (const MapCorrection kind :
       {MapCorrection::Follow, MapCorrection::Spread, MapCorrection::Keep}) {
    std::mt19937 random(5);
    OccupancyMap plain, inner;
    LocalizedMap localized(inner, kind, 7);
    for (int i = 0; i < 40; ++i) {
      Obstacles frame = randomFrame(random);
      EXPECT_FALSE(localized.update(frame, correction));
      frame.view.T_odom_base = correction * frame.view.T_odom_base;
      plain.update(frame);
    }
    expectSameMap(inner, plain);
  }
}

TEST(LocalizedMap, FramesBeyondTheMemoryStayWhereTheyAre) {
  Drive d(MapCorrection::Follow, 10);
  for (int i = 0; i < 30; ++i) d.frame(i, truePose(i), correction.inverse());
  Drive expected(MapCorrection::Keep);
  for (int i = 0; i < 20; ++i) expected.frame(i, truePose(i), correction.inverse());
  for (int i = 20; i < 30; ++i) expected.frame(i, truePose(i), SE2{});
  d.frame(30, truePose(30), SE2{});
  expected.frame(30, truePose(30), SE2{});
  expectSameMap(d.map, expected.map);
}

TEST(LocalizedMap, NothingMovesWhenOdometryBeginsAnew) {
  // The localiser makes up for odometry that starts at zero again: the robot stands where it stood.
  Drive d(MapCorrection::Follow);
  for (int i = 0; i < 30; ++i) d.frame(i, truePose(i), SE2{});
  for (int i = 30; i < 60; ++i) d.frame(i, truePose(i - 30), {0.05 * 30, 0.0, 0.0});
  EXPECT_EQ(d.corrections, 1);
  EXPECT_LT(d.farthest(), half_diagonal + 1e-6);
}

TEST(LocalizedMap, WhatWasForgottenDoesNotComeBack) {
  Drive d(MapCorrection::Follow);
  for (int i = 0; i < 30; ++i) d.frame(i, truePose(i), SE2{});
  d.localized.clear();
  for (int i = 30; i < 40; ++i) d.frame(i, truePose(i), SE2{});
  d.frame(40, truePose(40), correction);
  Drive expected(MapCorrection::Keep);
  for (int i = 30; i < 41; ++i) expected.frame(i, truePose(i), correction);
  expectSameMap(d.map, expected.map);
}

TEST(LocalizedMap, ConsumersSeeTheWholeMapChangeInNewGeometry) {
  Drive d(MapCorrection::Follow);
  for (int i = 0; i < 30; ++i) d.frame(i, truePose(i), SE2{});
  (void)d.map.takeChanges();
  const std::uint64_t revision = d.map.geometry().revision;
  d.frame(30, truePose(30), correction);
  EXPECT_NE(d.map.geometry().revision, revision);
  const auto changed = d.map.takeChanges();
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->width, d.map.geometry().width);
  EXPECT_EQ(changed->height, d.map.geometry().height);
}

}  // namespace
}  // namespace ipm_mapping
