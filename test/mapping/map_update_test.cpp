#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

#include "mapping/support/map_frames.hpp"

namespace ipm_mapping {
namespace {

using namespace map_test;  // NOLINT(google-build-using-namespace)

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

// --- what was taken away ----------------------------------------------------------

/// Frames over free floor until a cell that was as sure as can be is no longer occupied.
int framesUntilGone(const MapParameters& parameters) {
  OccupancyMap map(parameters);
  Obstacles seen = frameAt({});
  seen.contacts = {contactAt(1.02F, 0.02F)};
  for (int i = 0; i < 100; ++i) map.update(seen);
  Obstacles gone = frameAt({});
  gone.bearings = {bearing(BearingState::Free, 0.02F, 2.0F)};
  for (int frames = 1; frames < 1000; ++frames) {
    map.update(gone);
    if (occupancyAt(map, 1.02, 0.02) != 100) return frames;
  }
  return -1;
}

TEST(LogOddsMap, WhatWasTakenAwayIsGoneAsFastAsClampAndMissSay) {
  MapParameters parameters = withUpdate(MapUpdate::LogOdds);
  EXPECT_EQ(framesUntilGone(parameters), 12) << "(3.5 - 0.62) / 0.25";
  parameters.miss = 0.5;
  EXPECT_EQ(framesUntilGone(parameters), 6);
  parameters.miss = 0.25;
  parameters.clamp = 2.0;
  EXPECT_EQ(framesUntilGone(parameters), 6);
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

TEST(LogOddsMap, ARayIsNoLongerThanTheMapCanBeAndThenHasNoObstacleAtItsEnd) {
  MapParameters parameters = withoutMargin();
  parameters.max_side = 128;
  OccupancyMap map(parameters);
  Obstacles frame = frameAt({-3.0, -3.0, M_PI / 4.0});
  frame.bearings = {bearing(BearingState::Occupied, 0.0F, 20.0F)};
  map.update(frame);
  const double end = -3.0 + 128 * parameters.resolution * std::sqrt(0.5);
  EXPECT_TRUE(map.logOdds(cellAt(end, end)));
  EXPECT_FALSE(map.logOdds(cellAt(end + 0.06, end + 0.06)));
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

TEST(LogOddsMap, WhatMovesIsNotKept) {
  OccupancyMap map;
  Obstacles frame = frameAt({});
  frame.contacts = {contactAt(0.5F, 0.0F), contactAt(0.8F, 0.0F)};
  frame.contacts[1].moving = true;
  map.update(frame);
  EXPECT_GT(valueAt(map, 0.5, 0.0), 0.0F);
  EXPECT_FALSE(valueAt(map, 0.8, 0.0) > 0.0F);
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

}  // namespace
}  // namespace ipm_mapping
