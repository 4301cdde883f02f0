#include "ipm_mapping/mapping/map_io.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

namespace ipm_mapping {
namespace {

class MapIo : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "map_io_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream in(path(name), std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    return all.str();
  }
  /// A YAML as map_server writes it, with one line replaced or added.
  void writeYaml(const std::string& key, const std::string& line) const {
    std::string text;
    for (const std::string& each :
         {std::string("image: map.pgm"), std::string("resolution: 0.05"),
          std::string("origin: [-1.0, 2.5, 0]"), std::string("negate: 0"),
          std::string("occupied_thresh: 0.65"), std::string("free_thresh: 0.196")})
      if (each.compare(0, key.size(), key) != 0) text += each + "\n";
    write("map.yaml", text + line + "\n");
  }
  [[nodiscard]] std::string loadError() const {
    TrinaryMap map;
    map.width = 77;
    const std::string error = loadMap(path("map.yaml"), map).value_or("");
    EXPECT_TRUE(error.empty() || map.width == 77) << "a map that cannot be read stays as it was";
    return error;
  }

  std::string folder_;
};

TrinaryMap randomMap(int width, int height) {
  TrinaryMap map;
  map.resolution = 0.05;
  map.origin_x = -64 * 0.05;
  map.origin_y = 192 * 0.05;
  map.width = width;
  map.height = height;
  std::mt19937 random(5);
  for (int i = 0; i < width * height; ++i) {
    const std::int8_t values[] = {-1, 0, 100};
    map.cells.push_back(values[random() % 3]);
  }
  return map;
}

TEST_F(MapIo, WhatIsSavedIsLoadedAgain) {
  const TrinaryMap saved = randomMap(37, 23);
  ASSERT_EQ(saveMap(saved, path("map")), std::nullopt);
  TrinaryMap loaded;
  ASSERT_EQ(loadMap(path("map.yaml"), loaded), std::nullopt);
  EXPECT_EQ(loaded.cells, saved.cells);
  EXPECT_EQ(loaded.width, 37);
  EXPECT_EQ(loaded.height, 23);
  EXPECT_DOUBLE_EQ(loaded.resolution, 0.05);
  EXPECT_DOUBLE_EQ(loaded.origin_x, -3.2);
  EXPECT_DOUBLE_EQ(loaded.origin_y, 9.6);
}

TEST_F(MapIo, AnyNameIsReadAsItWasWritten) {
  const TrinaryMap saved = randomMap(3, 2);
  for (const char* name : {"a: b #c", "[1]", "'quoted'", "yes", "- 7", "K\303\274che"}) {
    ASSERT_EQ(saveMap(saved, path(name)), std::nullopt) << name;
    TrinaryMap loaded;
    EXPECT_EQ(loadMap(path(name) + ".yaml", loaded), std::nullopt) << name;
    EXPECT_EQ(loaded.cells, saved.cells) << name;
  }
}

TEST_F(MapIo, WritesTheBytesThatMapServerWrites) {
  TrinaryMap map;
  map.origin_x = -3.2000000000000002;
  map.width = 2;
  map.height = 2;
  map.cells = {0, 100, -1, 0};  // the lower row first
  ASSERT_EQ(saveMap(map, path("floor")), std::nullopt);
  EXPECT_EQ(read("floor.pgm"), std::string("P5\n2 2\n255\n") + char(205) + char(254) + char(254) +
                                   std::string(1, '\0'));
  EXPECT_EQ(read("floor.yaml"),
            "image: floor.pgm\nresolution: 0.05\norigin: [-3.2, 0, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST_F(MapIo, ReplacesAnOlderMapAndLeavesNoTemporaryFile) {
  ASSERT_EQ(saveMap(randomMap(64, 64), path("map")), std::nullopt);
  ASSERT_EQ(saveMap(randomMap(8, 8), path("map")), std::nullopt);
  TrinaryMap loaded;
  ASSERT_EQ(loadMap(path("map.yaml"), loaded), std::nullopt);
  EXPECT_EQ(loaded.width, 8);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    files += !entry.path().empty();
  EXPECT_EQ(files, 2);
}

TEST_F(MapIo, SavingSaysWhatFailedAndWhere) {
  EXPECT_NE(saveMap(TrinaryMap{}, path("map"))->find("map.pgm"), std::string::npos);
  const auto error = saveMap(randomMap(4, 4), path("no_such_folder/map"));
  ASSERT_TRUE(error);
  EXPECT_NE(error->find("no_such_folder/map.pgm"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path("no_such_folder")));
}

TEST_F(MapIo, ReadsCommentsPlainTextNegateAndOtherThresholds) {
  write("map.pgm", "P2 # a comment\n# another\n3 1 # size\n100\n0 100\n30\n");
  writeYaml("negate", "negate: 1");
  TrinaryMap map;
  ASSERT_EQ(loadMap(path("map.yaml"), map), std::nullopt);
  EXPECT_EQ(map.cells, (std::vector<std::int8_t>{0, 100, -1}));
  EXPECT_DOUBLE_EQ(map.origin_y, 2.5);
  writeYaml("occupied_thresh", "occupied_thresh: 0.2");
  ASSERT_EQ(loadMap(path("map.yaml"), map), std::nullopt);
  EXPECT_EQ(map.cells, (std::vector<std::int8_t>{100, 0, 100}));
}

TEST_F(MapIo, LoadingNamesTheFileAndTheField) {
  EXPECT_NE(loadError().find("map.yaml: No such file"), std::string::npos);
  write("map.pgm", std::string("P5\n2 1\n255\n") + "ab");
  const std::pair<const char*, const char*> wrong[] = {{"resolution", "resolution: 0"},
                                                       {"resolution", "resolution: wide"},
                                                       {"resolution", ""},
                                                       {"origin", "origin: [1, 2]"},
                                                       {"origin", "origin: [0, 0, 0.3]"},
                                                       {"origin", "origin: [.nan, 0, 0]"},
                                                       {"mode", "mode: scale"},
                                                       {"negate", "negate: maybe"},
                                                       {"image", ""},
                                                       {"occupied_thresh", ""},
                                                       {"free_thresh", "free_thresh: []"}};
  for (const auto& [key, line] : wrong) {
    writeYaml(key, line);
    const std::string error = loadError();
    EXPECT_NE(error.find("map.yaml"), std::string::npos) << line;
    EXPECT_NE(error.find("'" + std::string(key) + "'"), std::string::npos) << error;
  }
  writeYaml("image", "image: other.pgm");
  EXPECT_NE(loadError().find("other.pgm: No such file"), std::string::npos);
  write("map.yaml", "- 1\n");
  EXPECT_NE(loadError().find("map.yaml"), std::string::npos);
  write("map.yaml", "a: [");
  EXPECT_NE(loadError().find("map.yaml"), std::string::npos);
}

TEST_F(MapIo, PicturesThatCannotBeReadAreRefused) {
  writeYaml("none", "");
  for (const char* pgm :
       {"", "P6\n1 1\n255\nabc", "P5\n2 2\n255\nabc", "P5\n2 2\n65535\nabcdefgh",
        "P5\n-1 2\n255\nabcd", "P5\n0 2\n255\nabcd", "P5\n99999999999999999999 2\n255\nabcd",
        "P5\n2000000000 2000000000\n255\nabcd", "P5\n2", "P2\n2 1\n255\n1 #", "P5\n# endless"}) {
    write("map.pgm", pgm);
    EXPECT_NE(loadError().find("map.pgm"), std::string::npos) << pgm;
  }
}

TEST_F(MapIo, AnAbsoluteImagePathIsTakenAsItIs) {
  write("elsewhere.pgm", std::string("P5\n1 1\n255\n") + std::string(1, '\0'));
  writeYaml("image", "image: " + path("elsewhere.pgm"));
  EXPECT_EQ(loadError(), "");
}

}  // namespace
}  // namespace ipm_mapping
