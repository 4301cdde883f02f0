#include "ipm_mapping/ros/confined_path.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace ipm_mapping {
namespace {

namespace fs = std::filesystem;

class ConfinedPathTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / "confined_path_test";
    fs::remove_all(root_);
    fs::create_directories(root_ / "outside");
    inside_ = (root_ / "inside").string();
  }
  void TearDown() override { fs::remove_all(root_); }
  fs::path root_;
  std::string inside_;
};

TEST_F(ConfinedPathTest, NamesBelowTheDirectoryAreTakenAndTheirFoldersMade) {
  const ConfinedPath path = confine(inside_, "a/b/map");
  ASSERT_EQ(path.error, std::nullopt);
  EXPECT_EQ(fs::path(path.path), fs::canonical(inside_) / "a/b/map");
  EXPECT_TRUE(fs::is_directory(root_ / "inside/a/b"));
  EXPECT_EQ(confine(inside_, "a/../map").error, std::nullopt) << "stays inside";
}

TEST_F(ConfinedPathTest, WhateverLeadsOutIsRefused) {
  for (const char* name : {"../outside/x", "..", "/etc/passwd", "a/../../outside/x", "", ".", "a/",
                           "../inside_too/x"}) {
    const ConfinedPath path = confine(inside_, name);
    EXPECT_TRUE(path.error) << name;
    EXPECT_TRUE(path.path.empty()) << name;
  }
  EXPECT_TRUE(confine(inside_, std::string("a\0b", 3)).error);
}

TEST_F(ConfinedPathTest, LinksThatLeadOutAreRefused) {
  fs::create_directories(inside_);
  fs::create_directory_symlink(root_ / "outside", fs::path(inside_) / "link");
  EXPECT_TRUE(confine(inside_, "link/x").error);
}

TEST_F(ConfinedPathTest, DirectoryThatCannotBeMadeIsAnErrorNotACrash) {
  EXPECT_TRUE(confine("/proc/nowhere/maps", "x").error);
}

TEST_F(ConfinedPathTest, HomeIsExpanded) {
  const std::string home = std::getenv("HOME");
  EXPECT_EQ(expandHome("~/maps"), home + "/maps");
  EXPECT_EQ(expandHome("~"), home);
  EXPECT_EQ(expandHome("/a/~/b"), "/a/~/b");
  EXPECT_EQ(expandHome("~other/b"), "~other/b");
}

}  // namespace
}  // namespace ipm_mapping
