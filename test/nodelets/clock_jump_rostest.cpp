// A bag that loops: everything of before the jump is forgotten once, and the second pass answers
// what the first one did.

#include <gtest/gtest.h>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

TEST(ClockJump, IsOneResetAndTheSecondPassIsLikeTheFirst) {
  ros::NodeHandle node;
  Diagnostics diagnostics(node);
  Collected<ObstacleArray> obstacles(node, "/camera/obstacles");
  Collected<nav_msgs::OccupancyGrid> maps(node, "/camera/map");
  Collected<nav_msgs::OccupancyGrid> forgetful(node, "/forgetful/map");
  RobotTopics topics(node);
  topics.tellTf();
  ASSERT_TRUE(topics.waitForListeners());

  topics.play(0, 20);
  ASSERT_TRUE(diagnostics.waitFor("ipm", "received", 20));
  ASSERT_TRUE(waitFor([&] { return obstacles.size() >= 15; }));
  ros::WallDuration(0.5).sleep();
  ros::spinOnce();
  const std::size_t first = obstacles.size();
  ASSERT_TRUE(waitFor([&] { return maps.last().header.stamp == obstacles.last().header.stamp; }));
  const nav_msgs::OccupancyGrid after_first_pass = maps.last();

  topics.play(0, 20);
  ASSERT_TRUE(diagnostics.waitFor("ipm", "received", 40));
  ASSERT_TRUE(waitFor([&] { return obstacles.size() >= 2 * first; }));
  ros::WallDuration(1.5).sleep();
  ros::spinOnce();
  ASSERT_EQ(obstacles.size(), 2 * first);
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
  ASSERT_TRUE(waitFor([&] {
    return maps.last().header.stamp == obstacles.last().header.stamp &&
           forgetful.last().header.stamp == obstacles.last().header.stamp;
  }));
  ros::WallDuration(1.5).sleep();
  ros::spinOnce();
  EXPECT_EQ(forgetful.last().data, after_first_pass.data);
  EXPECT_NE(maps.last().data, after_first_pass.data);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "clock_jump_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
