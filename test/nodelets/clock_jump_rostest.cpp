// A bag that loops: everything of before the jump is forgotten once, and the second pass answers
// what the first one did.

#include <gtest/gtest.h>

#include <algorithm>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

std::ptrdiff_t knownCells(const nav_msgs::OccupancyGrid& map) {
  return std::count_if(map.data.begin(), map.data.end(), [](auto cell) { return cell != -1; });
}

TEST(ClockJump, IsOneResetAndTheSecondPassIsLikeTheFirst) {
  ros::NodeHandle node;
  Diagnostics diagnostics(node);
  Collected<ObstacleArray> obstacles(node, "/camera/obstacles");
  Collected<nav_msgs::OccupancyGrid> maps(node, "/camera/map");
  Collected<nav_msgs::OccupancyGrid> forgetful(node, "/forgetful/map");
  RobotTopics topics(node);
  topics.tellTf();
  ASSERT_TRUE(waitForPublishers(obstacles, maps, forgetful));
  ASSERT_TRUE(topics.waitForListeners());
  // A mapper advertises its map before it subscribes; it reports once it does both.
  for (const char* mapper : {"mapper", "forgetful"})
    ASSERT_TRUE(waitFor([&] { return !diagnostics.sentences[mapper].empty(); })) << mapper;

  // The robot drives until the end: the last frame is answered, and all before it are.
  const auto answered = [&](unsigned frame) {
    return obstacles.size() > 0 && obstacles.last().frame == frame;
  };
  const auto mapped = [&](const Collected<nav_msgs::OccupancyGrid>& grids) {
    return grids.size() > 0 && grids.last().header.stamp == obstacles.last().header.stamp;
  };
  topics.play(0, 20);
  ASSERT_TRUE(waitFor([&] { return answered(19); }));
  const std::size_t first = obstacles.size();
  ASSERT_GE(first, 15U);
  ASSERT_TRUE(waitFor([&] { return mapped(maps) && mapped(forgetful); }));
  const nav_msgs::OccupancyGrid after_first_pass = maps.last();
  const std::size_t forgetful_before = forgetful.size();

  topics.play(0, 20);
  ASSERT_TRUE(waitFor([&] { return answered(39); }));
  ASSERT_EQ(obstacles.size(), 2 * first);
  const auto all = static_cast<double>(2 * first);
  for (const char* nodelet : {"ipm", "segmentation", "mapper"})
    ASSERT_TRUE(diagnostics.waitFor(nodelet, "used", all)) << nodelet;
  EXPECT_EQ(diagnostics.value("ipm", "resets"), 1.0);
  EXPECT_EQ(diagnostics.value("segmentation", "resets"), 1.0);
  EXPECT_EQ(diagnostics.value("mapper", "resets"), 1.0);
  for (std::size_t i = 0; i < first; ++i) {
    const ObstacleArray &a = *obstacles.all[i], &b = *obstacles.all[first + i];
    EXPECT_EQ(a.header.stamp, b.header.stamp);
    EXPECT_EQ(a.frame + 20, b.frame);
    EXPECT_EQ(a.threshold, b.threshold);
    EXPECT_EQ(a.view.reference_stamp, b.view.reference_stamp);
    ASSERT_EQ(a.contacts.size(), b.contacts.size());
    ASSERT_EQ(a.bearings.size(), b.bearings.size());
    for (std::size_t k = 0; k < a.bearings.size(); ++k)
      EXPECT_EQ(a.bearings[k].range, b.bearings[k].range);
  }
  // The mapper that forgets knows what one pass shows; the one that remembers has seen it twice.
  const auto forgot = [&](const nav_msgs::OccupancyGridConstPtr& map) {
    return knownCells(*map) < knownCells(after_first_pass);
  };
  EXPECT_TRUE(waitFor([&] {
    const auto second_pass = forgetful.all.begin() + static_cast<std::ptrdiff_t>(forgetful_before);
    return std::any_of(second_pass, forgetful.all.end(), forgot) &&
           forgetful.last().data == after_first_pass.data;
  }));
  EXPECT_TRUE(waitFor([&] { return maps.last().data != after_first_pass.data; }));
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "clock_jump_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
