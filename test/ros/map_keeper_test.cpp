#include "ipm_mapping/ros/map_keeper.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "ipm_mapping/mapping/occupancy_map.hpp"

namespace ipm_mapping {
namespace {

class Keeper : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "map_keeper_XXXXXX").string();
    parameters.directory = mkdtemp(pattern.data());
    parameters.initial_map = parameters.directory + "/" + parameters.autosave_name + ".yaml";
  }
  void TearDown() override { std::filesystem::remove_all(parameters.directory); }

  MapperParameters parameters;
};

/// As after reset_map: the robot may be a kilometre from the frame's origin when it goes on.
TEST_F(Keeper, AnAutosaveInWhichNothingIsKnownBindsTheMapToNoPlace) {
  OccupancyMap forgotten, reopened;
  MapKeeper before(forgotten, parameters);
  before.touch();
  ASSERT_EQ(before.autosave(), std::nullopt);
  ASSERT_TRUE(std::filesystem::exists(parameters.initial_map));
  EXPECT_EQ(MapKeeper(reopened, parameters).loadInitialMap(), std::nullopt);
  EXPECT_TRUE(reopened.geometry().empty());
  EXPECT_TRUE(reopened.include({1000.0, 0.0}));
}

/// Said at the start, not when the map is lost.
TEST_F(Keeper, SaysWhyNothingCanBeSavedInItsFolder) {
  OccupancyMap map;
  parameters.directory += "/of/maps";
  EXPECT_EQ(MapKeeper(map, parameters).makeFolder(), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_directory(parameters.directory));
  parameters.directory = "/proc/maps/of/nobody";
  const auto notice = MapKeeper(map, parameters).makeFolder();
  ASSERT_TRUE(notice);
  EXPECT_NE(notice->find("/proc/maps/of/nobody"), std::string::npos) << *notice;
}

TEST_F(Keeper, AMapInWhichSomethingIsKnownComesBack) {
  OccupancyMap map, reopened;
  ASSERT_TRUE(map.include({0.5, 0.0}));
  TrinaryMap known;
  map.copyTo(known);
  known.cells.front() = 100;
  ASSERT_EQ(map.load(known), std::nullopt);
  MapKeeper before(map, parameters);
  before.touch();
  ASSERT_EQ(before.autosave(), std::nullopt);
  EXPECT_EQ(MapKeeper(reopened, parameters).loadInitialMap(), std::nullopt);
  EXPECT_FALSE(reopened.geometry().empty());
}

}  // namespace
}  // namespace ipm_mapping
