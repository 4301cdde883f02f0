#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "mapping/support/map_frames.hpp"

namespace ipm_mapping {
namespace {

using namespace map_test;  // NOLINT(google-build-using-namespace)

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
  EXPECT_EQ(knownCells(map), 0);
  EXPECT_EQ(map.counters().rejected, 5U);
  const std::uint64_t revision = map.geometry().revision;
  frame = frameAt({std::nan(""), 0.0, 0.0});
  frame.contacts = {contactAt(0.3F, 0.0F)};
  map.update(frame);
  EXPECT_EQ(map.geometry().revision, revision);
  EXPECT_EQ(map.counters().rejected_frames, 1U);
  EXPECT_EQ(map.counters().frames, 1U);
}

TEST(OccupancyMap, ARangeOfZeroIsTheCellUnderTheCamera) {
  OccupancyMap map;
  Obstacles frame = frameAt({-0.31, 0.0, 0.0}, 0.1);
  frame.bearings = {bearing(BearingState::Free, 0.3F, 0.0F)};
  map.update(frame);
  EXPECT_EQ(knownCells(map), 1);
  EXPECT_TRUE(map.logOdds(cellAt(-0.21, 0.0)));
}

TEST(OccupancyMap, AFloorThatComesIntoViewBehindTheRangeClearsNothing) {
  OccupancyMap map;
  Obstacles frame = frameAt({});
  frame.bearings = {bearing(BearingState::Occupied, 0.0F, 0.3F, 0.4F)};
  map.update(frame);
  EXPECT_EQ(knownCells(map), 0);
}

TEST(OccupancyMap, TheRobotStandsInItWithSomeRoomAround) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  for (int i = 0; i < 50; ++i) {
    OccupancyMap map;
    const SE2 pose{place(random), place(random), place(random)};
    Obstacles frame = frameAt(pose);
    frame.bearings = {bearing(BearingState::Free, 0.0F, 2.0F, 1.4F)};  // floor far ahead only
    map.update(frame);
    const MapGeometry& g = map.geometry();
    EXPECT_LE(g.originX(), pose.x - 0.5 + 1e-9);
    EXPECT_LE(g.originY(), pose.y - 0.5 + 1e-9);
    EXPECT_GE(g.originX() + g.width * g.resolution, pose.x + 0.5 - 1e-9);
    EXPECT_GE(g.originY() + g.height * g.resolution, pose.y + 0.5 - 1e-9);
  }
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
    EXPECT_EQ(knownCells(map), static_cast<int>(placed.size()));
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
  OccupancyMap map(withoutMargin());
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
  OccupancyMap map(withoutMargin());
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
