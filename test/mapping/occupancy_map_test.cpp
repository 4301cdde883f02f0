#include "ipm_mapping/mapping/occupancy_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>

namespace ipm_mapping {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// A frame of a robot at `pose` whose camera stands over (camera_x, 0) of base.
Obstacles frameAt(const SE2& pose, double camera_x = 0.0) {
  Obstacles frame;
  frame.view.T_odom_base = pose;
  frame.view.T_base_camera = cameraPose(camera_x, 0.0, 0.45, 0.42);
  return frame;
}

Bearing bearing(BearingState state, float angle, float range, float near = 0.0F) {
  Bearing b;
  b.state = state;
  b.angle = angle;
  b.range = range;
  b.near = near;
  return b;
}

Contact contactAt(float x, float y, float range_sigma = 0.0F) {
  Contact c;
  c.p_base = {x, y};
  c.range_sigma = range_sigma;
  return c;
}

Cell cellAt(double x, double y, double resolution = 0.05) {
  return cellOf(Eigen::Vector2d(x, y) / resolution);
}

float valueAt(const OccupancyMap& map, double x, double y) {
  return map.logOdds(cellAt(x, y)).value_or(nan);
}

std::int8_t occupancyAt(const OccupancyMap& map, double x, double y) {
  const MapGeometry& g = map.geometry();
  const Cell cell = cellAt(x, y);
  return map.occupancy(static_cast<std::size_t>(cell.y - g.first.y) *
                           static_cast<std::size_t>(g.width) +
                       static_cast<std::size_t>(cell.x - g.first.x));
}

MapParameters withUpdate(MapUpdate update) {
  MapParameters p;
  p.update = update;
  return p;
}

// --- mark_once -------------------------------------------------------------------

TEST(MarkOnceMap, OccupiesTheCellOfAContactForGoodAndFreesNothing) {
  OccupancyMap map(withUpdate(MapUpdate::MarkOnce));
  Obstacles frame = frameAt({1.0, 2.0, M_PI / 2.0});
  frame.contacts = {contactAt(0.52F, 0.13F)};
  map.update(frame);
  Obstacles free = frameAt({1.0, 2.0, M_PI / 2.0});
  for (int i = -20; i <= 20; ++i)
    free.bearings.push_back(bearing(BearingState::Free, static_cast<float>(i) * 0.02F, 2.0F));
  for (int i = 0; i < 50; ++i) map.update(free);
  int occupied = 0;
  const auto size = static_cast<std::size_t>(map.geometry().width * map.geometry().height);
  for (std::size_t i = 0; i < size; ++i) {
    occupied += map.occupancy(i) == 100;
    EXPECT_NE(map.occupancy(i), 0);
    EXPECT_EQ(map.probability(i), map.occupancy(i));
  }
  EXPECT_EQ(occupied, 1);
  EXPECT_EQ(occupancyAt(map, 1.0 - 0.13, 2.0 + 0.52), 100);
}

// --- log odds against a brute-force oracle ----------------------------------------

/// The rule of log_odds written down plainly: per frame, sets of missed and hit cells from densely
/// sampled rays.
class PlainMap {
 public:
  explicit PlainMap(const MapParameters& p) : p_(p) {}

  void update(const Obstacles& frame) {
    std::map<std::pair<int, int>, double> change;
    const Eigen::Vector2d foot = frame.view.T_odom_base * frame.view.cameraFoot();
    for (const Bearing& b : frame.bearings) castRay(b, frame, foot, change);
    std::map<std::pair<int, int>, double> hits;
    for (const Contact& c : frame.contacts) {
      double gain = p_.hit;
      if (c.range_sigma > 0) gain *= std::min(1.0, p_.resolution / (2.0 * c.range_sigma));
      const Eigen::Vector2d point = frame.view.T_odom_base * c.p_base.cast<double>();
      double& hit = hits[key(point)];
      hit = std::max(hit, gain);
    }
    for (const auto& [cell, gain] : hits) change[cell] = gain;
    for (const auto& [cell, step] : change)
      value_[cell] = std::min(p_.clamp, std::max(-p_.clamp, value_[cell] + step));
  }
  [[nodiscard]] const std::map<std::pair<int, int>, double>& cells() const { return value_; }

 private:
  [[nodiscard]] std::pair<int, int> key(const Eigen::Vector2d& point) const {
    return {static_cast<int>(std::floor(point.x() / p_.resolution)),
            static_cast<int>(std::floor(point.y() / p_.resolution))};
  }
  void castRay(const Bearing& b, const Obstacles& frame, const Eigen::Vector2d& foot,
               std::map<std::pair<int, int>, double>& change) const {
    if (b.state == BearingState::Unknown) return;
    const double heading = frame.view.T_odom_base.theta + b.angle;
    const Eigen::Vector2d d(std::cos(heading), std::sin(heading));
    const auto end = key(foot + d * static_cast<double>(b.range));
    constexpr int samples = 200000;
    for (int i = 0; i <= samples; ++i) {
      const double r = b.near + (static_cast<double>(b.range) - b.near) * i / samples;
      const auto cell = key(foot + r * d);
      if (b.state == BearingState::Occupied && cell == end) continue;
      change[cell] = -p_.miss;
    }
  }

  MapParameters p_;
  std::map<std::pair<int, int>, double> value_;
};

Obstacles randomFrame(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  Obstacles frame =
      frameAt({3.0 * unit(random) - 2.0, 3.0 * unit(random) - 2.0, 6.3 * unit(random) - 3.1}, 0.07);
  for (int i = 0; i < 12; ++i) {
    const auto state = static_cast<BearingState>(random() % 4);
    const float angle = 0.5F - 0.09F * static_cast<float>(i), range = 0.3F + unit(random);
    frame.bearings.push_back(bearing(state, angle, range, 0.3F * unit(random)));
    if (state == BearingState::Occupied && random() % 4 != 0)
      frame.contacts.push_back(contactAt(0.07F + range * std::cos(angle), range * std::sin(angle),
                                         random() % 2 ? 0.2F * unit(random) : 0.0F));
  }
  return frame;
}

TEST(LogOddsMap, AgreesWithTheRuleWrittenDownPlainly) {
  const MapParameters parameters;
  OccupancyMap map(parameters);
  PlainMap plain(parameters);
  std::mt19937 random(11);
  for (int i = 0; i < 25; ++i) {
    const Obstacles frame = randomFrame(random);
    map.update(frame);
    plain.update(frame);
  }
  // A ray may clip a corner by less than the oracle samples: a few cells of thousands.
  int only_here = 0, same = 0;
  const MapGeometry& g = map.geometry();
  for (int y = 0; y < g.height; ++y)
    for (int x = 0; x < g.width; ++x) {
      const Cell cell{g.first.x + x, g.first.y + y};
      const auto value = map.logOdds(cell);
      const auto expected = plain.cells().find({cell.x, cell.y});
      const bool known = expected != plain.cells().end();
      if (!value) {
        EXPECT_FALSE(known);
        continue;
      }
      if (known && std::abs(expected->second - static_cast<double>(*value)) < 1e-4)
        ++same;
      else
        ++only_here;
    }
  EXPECT_GT(same, 1000);
  EXPECT_LE(only_here, same / 500);
}

TEST(LogOddsMap, ClearsFromWhereTheFloorComesIntoViewUpToTheRange) {
  OccupancyMap map;
  Obstacles frame = frameAt({0.0, 0.025, 0.0}, 0.1);
  frame.bearings = {bearing(BearingState::Free, 0.0F, 0.80F, 0.31F)};
  map.update(frame);
  for (double x = -0.175; x < 1.2; x += 0.05) {
    const bool seen = cellAt(x, 0.0).x >= cellAt(0.41, 0.0).x && x < 0.9 + 0.05;
    EXPECT_EQ(map.logOdds(cellAt(x, 0.025)).has_value(), seen) << x;
  }
}

TEST(LogOddsMap, StateDecidesWhetherTheLastCellIsFree) {
  const std::pair<BearingState, bool> cases[] = {{BearingState::Free, true},
                                                 {BearingState::Blocked, true},
                                                 {BearingState::Occupied, false},
                                                 {BearingState::Unknown, false}};
  for (const auto& [state, last_is_free] : cases) {
    OccupancyMap map;
    map.include({0.0, 0.0});
    Obstacles frame = frameAt({0.0, 0.025, 0.0});
    frame.bearings = {bearing(state, 0.0F, 0.52F)};
    map.update(frame);
    EXPECT_EQ(map.logOdds(cellAt(0.52, 0.025)).has_value(), last_is_free);
    EXPECT_EQ(map.logOdds(cellAt(0.47, 0.025)).has_value(), state != BearingState::Unknown);
  }
}

TEST(LogOddsMap, ManyRaysAndContactsInOneCellCountOnce) {
  const MapParameters parameters;
  OccupancyMap map(parameters);
  Obstacles frame = frameAt({0.025, 0.025, 0.0});
  for (int i = -30; i <= 30; ++i)
    frame.bearings.push_back(bearing(BearingState::Free, static_cast<float>(i) * 0.005F, 1.0F));
  for (int i = 0; i < 5; ++i) frame.contacts.push_back(contactAt(0.5F, 0.0F));
  map.update(frame);
  EXPECT_FLOAT_EQ(valueAt(map, 0.225, 0.025), static_cast<float>(-parameters.miss));
  EXPECT_FLOAT_EQ(valueAt(map, 0.525, 0.025), static_cast<float>(parameters.hit))
      << "a hit wins over the rays that go on behind it";
}

TEST(LogOddsMap, AnUncertainContactWeighsLess) {
  MapParameters parameters;
  OccupancyMap map(parameters);
  Obstacles frame = frameAt({});
  frame.contacts = {contactAt(0.31F, 0.0F, 0.1F), contactAt(0.61F, 0.0F, 0.01F),
                    contactAt(0.91F, 0.0F, nan)};
  map.update(frame);
  EXPECT_FLOAT_EQ(valueAt(map, 0.31, 0.0), static_cast<float>(parameters.hit * 0.25));
  EXPECT_FLOAT_EQ(valueAt(map, 0.61, 0.0), static_cast<float>(parameters.hit));
  EXPECT_FLOAT_EQ(valueAt(map, 0.91, 0.0), static_cast<float>(parameters.hit));
}

TEST(LogOddsMap, ARememberedContactIsNoNewEvidence) {
  OccupancyMap map;
  Obstacles frame = frameAt({});
  frame.contacts = {contactAt(0.5F, 0.0F)};
  map.update(frame);
  const float once = valueAt(map, 0.5, 0.0);
  frame.contacts[0].age = 0.3F;
  map.update(frame);
  EXPECT_EQ(valueAt(map, 0.5, 0.0), once);
}

TEST(LogOddsMap, ClampBoundsBothSidesSoThatTheMapCanChangeItsMind) {
  MapParameters parameters;
  OccupancyMap map(parameters);
  Obstacles hit = frameAt({0.0, 0.025, 0.0}), miss = frameAt({0.0, 0.025, 0.0});
  hit.contacts = {contactAt(0.525F, 0.0F)};
  miss.bearings = {bearing(BearingState::Free, 0.0F, 1.0F)};
  for (int i = 0; i < 100; ++i) map.update(hit);
  EXPECT_FLOAT_EQ(valueAt(map, 0.525, 0.025), static_cast<float>(parameters.clamp));
  EXPECT_EQ(occupancyAt(map, 0.525, 0.025), 100);
  const int enough = static_cast<int>(std::ceil(2.0 * parameters.clamp / parameters.miss));
  for (int i = 0; i < enough; ++i) map.update(miss);
  EXPECT_FLOAT_EQ(valueAt(map, 0.525, 0.025), static_cast<float>(-parameters.clamp));
  EXPECT_EQ(occupancyAt(map, 0.525, 0.025), 0);
}

TEST(LogOddsMap, ThresholdsIncludeTheirProbability) {
  MapParameters parameters;
  parameters.hit = std::log(3.0);
  parameters.miss = std::log(3.0);
  parameters.occupied_above = 0.75;
  parameters.free_below = 0.25;
  OccupancyMap map(parameters);
  Obstacles frame = frameAt({0.0, 0.025, 0.0});
  frame.contacts = {contactAt(0.525F, 0.0F)};
  frame.bearings = {bearing(BearingState::Occupied, 0.0F, 0.525F)};
  map.update(frame);
  EXPECT_EQ(occupancyAt(map, 0.525, 0.025), 100);
  EXPECT_EQ(occupancyAt(map, 0.225, 0.025), 0);
  Obstacles beyond = frameAt({0.0, 0.025, 0.0});
  beyond.bearings = {bearing(BearingState::Free, 0.0F, 1.0F)};
  map.update(beyond);
  EXPECT_EQ(occupancyAt(map, 0.525, 0.025), -1) << "hit and miss cancel: 50 % is undecided";
  const MapGeometry& g = map.geometry();
  const Cell cell = cellAt(0.525, 0.025);
  EXPECT_EQ(map.probability(
                static_cast<std::size_t>((cell.y - g.first.y) * g.width + cell.x - g.first.x)),
            50);
}

// --- edges of the domain -------------------------------------------------------------

TEST(OccupancyMap, WhatIsNotFiniteIsCountedAndLeavesTheMapAlone) {
  OccupancyMap map;
  Obstacles frame = frameAt({0.0, 0.0, 0.0});
  const float inf = std::numeric_limits<float>::infinity();
  frame.contacts = {contactAt(nan, 0.0F), contactAt(0.3F, inf)};
  frame.bearings = {bearing(BearingState::Free, nan, 1.0F), bearing(BearingState::Free, 0.0F, inf),
                    bearing(BearingState::Blocked, 0.0F, 1.0F, nan),
                    bearing(BearingState::Unknown, nan, nan, nan)};
  map.update(frame);
  EXPECT_TRUE(map.geometry().empty());
  EXPECT_EQ(map.counters().rejected, 5U);
  frame = frameAt({std::nan(""), 0.0, 0.0});
  frame.contacts = {contactAt(0.3F, 0.0F)};
  map.update(frame);
  EXPECT_TRUE(map.geometry().empty());
  EXPECT_EQ(map.counters().rejected_frames, 1U);
  EXPECT_EQ(map.counters().frames, 1U);
}

TEST(OccupancyMap, ARangeOfZeroIsTheCellUnderTheCamera) {
  OccupancyMap map;
  Obstacles frame = frameAt({-0.31, 0.0, 0.0}, 0.1);
  frame.bearings = {bearing(BearingState::Free, 0.3F, 0.0F)};
  map.update(frame);
  int known = 0;
  for (std::size_t i = 0; i < 64U * 64U; ++i) known += map.probability(i) >= 0;
  EXPECT_EQ(known, 1);
  EXPECT_TRUE(map.logOdds(cellAt(-0.21, 0.0)));
}

TEST(OccupancyMap, AFloorThatComesIntoViewBehindTheRangeClearsNothing) {
  OccupancyMap map;
  Obstacles frame = frameAt({});
  frame.bearings = {bearing(BearingState::Occupied, 0.0F, 0.3F, 0.4F)};
  map.update(frame);
  EXPECT_TRUE(map.geometry().empty());
}

TEST(OccupancyMap, GrowsInAllDirectionsByBlocksAndKeepsItsContent) {
  OccupancyMap map;
  const Eigen::Vector2f places[] = {{0.1F, 0.1F},  {9.0F, 0.2F},   {-7.0F, 0.3F},
                                    {0.0F, 12.0F}, {0.0F, -11.0F}, {-20.0F, -20.0F}};
  std::uint64_t revision = map.geometry().revision;
  std::vector<Eigen::Vector2f> placed;
  for (const Eigen::Vector2f& place : places) {
    Obstacles frame = frameAt({});
    frame.contacts = {contactAt(place.x(), place.y())};
    map.update(frame);
    placed.push_back(place);
    const MapGeometry& g = map.geometry();
    EXPECT_GT(g.revision, revision);
    revision = g.revision;
    EXPECT_EQ(g.width % 64, 0);
    EXPECT_EQ(g.height % 64, 0);
    EXPECT_EQ(((g.first.x % 64) + 64) % 64, 0);
    EXPECT_EQ(((g.first.y % 64) + 64) % 64, 0);
    EXPECT_DOUBLE_EQ(g.originX(), g.first.x * 0.05);
    int known = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(g.width * g.height); ++i)
      known += map.probability(i) >= 0;
    EXPECT_EQ(known, static_cast<int>(placed.size()));
    for (const Eigen::Vector2f& p : placed)
      EXPECT_EQ(occupancyAt(map, static_cast<double>(p.x()), static_cast<double>(p.y())), 100);
  }
}

TEST(OccupancyMap, InsideItsBlocksItsGeometryStays) {
  OccupancyMap map;
  ASSERT_TRUE(map.include({0.0, 0.0}));
  const std::uint64_t revision = map.geometry().revision;
  Obstacles frame = frameAt({0.5, 0.5, 0.0});
  frame.bearings = {bearing(BearingState::Free, 0.2F, 2.0F)};
  map.update(frame);
  EXPECT_EQ(map.geometry().revision, revision);
}

TEST(OccupancyMap, BeyondMaxSideIsCountedAndNotStored) {
  MapParameters parameters;
  parameters.max_side = 128;
  OccupancyMap map(parameters);
  Obstacles frame = frameAt({0.1, 0.1, 0.0});
  frame.contacts = {contactAt(1.0F, 1.0F), contactAt(50.0F, 0.0F), contactAt(1e30F, 0.0F)};
  frame.bearings = {bearing(BearingState::Free, 0.0F, 60.0F)};
  map.update(frame);
  EXPECT_EQ(map.counters().outside_contacts, 2U);
  EXPECT_EQ(map.counters().outside_rays, 1U);
  EXPECT_EQ(map.counters().hits, 1U);
  EXPECT_LE(map.geometry().width, 128);
  EXPECT_EQ(occupancyAt(map, 1.1, 1.1), 100);
  EXPECT_TRUE(map.logOdds(cellAt(3.0, 0.1))) << "the part of the ray inside is used";
  EXPECT_FALSE(map.include({1e12, 0.0}));
}

TEST(OccupancyMap, ABlockLargerThanTheLargestSideIsCutToIt) {
  MapParameters parameters;
  parameters.max_side = 100;
  parameters.block = 1024;
  OccupancyMap map(parameters);
  ASSERT_TRUE(map.include({-0.01, -0.01}));
  EXPECT_EQ(map.geometry().width, 100);
}

TEST(OccupancyMap, RefusesParametersOutsideTheirRange) {
  MapParameters parameters;
  parameters.resolution = 0.0;
  EXPECT_THROW(OccupancyMap{parameters}, ParameterError);
}

// --- what consumers read ----------------------------------------------------------------

TEST(OccupancyMap, ChangesAreTheSmallestRectangleAroundTheChangedCells) {
  OccupancyMap map;
  ASSERT_TRUE(map.include({0.0, 0.0}));
  const auto grown = map.takeChanges();
  ASSERT_TRUE(grown);
  EXPECT_EQ(grown->width, 64);
  EXPECT_FALSE(map.takeChanges());
  Obstacles frame = frameAt({});
  frame.contacts = {contactAt(0.26F, 0.51F), contactAt(0.11F, 1.01F)};
  map.update(frame);
  const auto changed = map.takeChanges();
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->x, 2);
  EXPECT_EQ(changed->y, 10);
  EXPECT_EQ(changed->width, 4);
  EXPECT_EQ(changed->height, 11);
  for (int i = 0; i < 10; ++i) map.update(frame);
  EXPECT_TRUE(map.takeChanges());
  map.update(frame);
  EXPECT_FALSE(map.takeChanges()) << "cells at their clamp do not change";
}

TEST(OccupancyMap, AfterAGrowthEverythingCountsAsChanged) {
  OccupancyMap map;
  map.include({0.0, 0.0});
  Obstacles frame = frameAt({});
  frame.contacts = {contactAt(1.0F, 1.0F)};
  map.update(frame);
  map.include({-0.1, 0.0});
  const auto changed = map.takeChanges();
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->x, 0);
  EXPECT_EQ(changed->width, 128);
  EXPECT_EQ(changed->height, 64);
}

TEST(OccupancyMap, ClearForgetsEverything) {
  OccupancyMap map;
  Obstacles frame = frameAt({});
  frame.contacts = {contactAt(1.0F, 1.0F)};
  map.update(frame);
  const std::uint64_t revision = map.geometry().revision;
  map.clear();
  EXPECT_TRUE(map.geometry().empty());
  EXPECT_GT(map.geometry().revision, revision);
  EXPECT_FALSE(map.takeChanges());
  map.include({1.0, 1.0});
  EXPECT_FALSE(map.logOdds(cellAt(1.0, 1.0)));
}

TEST(OccupancyMap, TheSameFramesMakeTheSameMap) {
  OccupancyMap one, other;
  std::mt19937 random_one(3), random_other(3);
  for (int i = 0; i < 20; ++i) {
    one.update(randomFrame(random_one));
    other.update(randomFrame(random_other));
  }
  TrinaryMap a, b;
  one.copyTo(a);
  other.copyTo(b);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.origin_x, b.origin_x);
}

// --- an earlier map -----------------------------------------------------------------------

TrinaryMap smallMap() {
  TrinaryMap map;
  map.origin_x = -0.30;
  map.origin_y = 0.15;
  map.width = 3;
  map.height = 2;
  map.cells = {0, 100, -1, -1, 0, 100};
  return map;
}

TEST(OccupancyMap, LoadsAMapAtItsPlaceInBothModes) {
  for (const MapUpdate update : {MapUpdate::LogOdds, MapUpdate::MarkOnce}) {
    OccupancyMap map(withUpdate(update));
    map.include({30.0, 30.0});
    ASSERT_EQ(map.load(smallMap()), std::nullopt);
    EXPECT_EQ(occupancyAt(map, -0.275, 0.175), 0);
    EXPECT_EQ(occupancyAt(map, -0.225, 0.175), 100);
    EXPECT_EQ(occupancyAt(map, -0.175, 0.175), -1);
    EXPECT_EQ(occupancyAt(map, -0.275, 0.225), -1);
    EXPECT_EQ(occupancyAt(map, -0.225, 0.225), 0);
    EXPECT_EQ(occupancyAt(map, -0.175, 0.225), 100);
    EXPECT_TRUE(map.takeChanges());
  }
}

TEST(OccupancyMap, ALoadedMapThatDoesNotFitIsRefusedAndTheMapStays) {
  MapParameters parameters;
  parameters.max_side = 128;
  OccupancyMap map(parameters);
  map.include({1.0, 1.0});
  const std::uint64_t revision = map.geometry().revision;
  TrinaryMap coarse = smallMap(), large = smallMap(), broken = smallMap();
  coarse.resolution = 0.1;
  large.width = 300;
  large.cells.assign(600, 0);
  broken.cells.pop_back();
  EXPECT_NE(map.load(coarse)->find("resolution"), std::string::npos);
  EXPECT_NE(map.load(large)->find("max_side"), std::string::npos);
  EXPECT_TRUE(map.load(broken));
  EXPECT_EQ(map.geometry().revision, revision);
}

}  // namespace
}  // namespace ipm_mapping
