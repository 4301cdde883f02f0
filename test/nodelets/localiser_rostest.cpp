// A localiser corrects, in the middle of a drive, where the odometry's frame lies: ten centimetres
// and three degrees. The obstacle seen before and after stands in the map once, and where it is.

#include <gtest/gtest.h>

#include <cmath>

#include "box_in_map.hpp"
#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

const SE2 wrong_start{0.08, 0.06, 0.0524};  // what the localiser believes at first
constexpr int corrected_at = 11;            // frame

geometry_msgs::TransformStamped odomInMap(double stamp, const SE2& T_map_odom) {
  geometry_msgs::TransformStamped message;
  message.header.stamp.fromSec(stamp);
  message.header.frame_id = "map";
  message.child_frame_id = SyntheticRobot::odom_frame;
  message.transform.translation.x = T_map_odom.x;
  message.transform.translation.y = T_map_odom.y;
  message.transform.rotation.z = std::sin(0.5 * T_map_odom.theta);
  message.transform.rotation.w = std::cos(0.5 * T_map_odom.theta);
  return message;
}

TEST(Localiser, ACorrectionMovesTheMapAndSmearsNothing) {
  ros::NodeHandle node;
  Diagnostics diagnostics(node);
  Collected<ObstacleArray> obstacles(node, "/camera/obstacles");
  Collected<nav_msgs::OccupancyGrid> following(node, "/camera/map"), keeping(node, "/keeping/map"),
      local(node, "/local/map");
  ros::Publisher tf = node.advertise<tf2_msgs::TFMessage>("/tf", 1000);
  RobotTopics topics(node);
  topics.tellTf();
  ASSERT_TRUE(waitForPublishers(obstacles, following, keeping, local));
  ASSERT_TRUE(topics.waitForListeners());
  ASSERT_TRUE(waitFor([&] { return tf.getNumSubscribers() >= 2; }));
  EXPECT_EQ(following.last().header.frame_id, "map") << "before anything was seen, too";

  // Nobody has placed odom yet: a mapper that needs it says so, the other one maps.
  topics.play(0, 7);
  const auto said = [&] {
    for (const auto& [sentence, times] : diagnostics.faults["mapper"])
      if (sentence == "tf does not know 'odom' in 'map'") return true;
    return false;
  };
  EXPECT_TRUE(waitFor(said));
  topics.time_shift = 100.0;

  const int frames = topics.robot.frames;
  for (int i = -1; i <= frames; ++i) {
    tf2_msgs::TFMessage message;
    const double stamp = topics.stamp(topics.robot.frameTime(i));
    message.transforms.push_back(odomInMap(stamp, i < corrected_at ? wrong_start : SE2{}));
    tf.publish(message);
  }
  waitFor([] { return false; }, 0.3);
  topics.play(0, frames);
  ASSERT_TRUE(waitFor([&] {
    const ros::Time end(topics.stamp(topics.robot.frameTime(frames - 1)));
    const auto arrived = [&](const auto& topic) {
      return topic.size() > 0 && std::abs((topic.last().header.stamp - end).toSec()) < 1e-3;
    };
    return arrived(obstacles) && arrived(following) && arrived(keeping) && arrived(local);
  }));

  EXPECT_TRUE(diagnostics.waitFor("mapper", "corrections", 1));
  EXPECT_EQ(following.last().header.frame_id, "map");
  EXPECT_EQ(local.last().header.frame_id, "odom");
  const Occupied followed(following.last()), kept(keeping.last());
  EXPECT_GE(followed.on_the_front, 6) << "the front of the box is eight cells wide";
  EXPECT_LT(followed.farthest, 0.07);
  EXPECT_GT(kept.farthest, 0.09) << "otherwise this test could not tell";
  // The detector works in odom and does not notice: its poses are those of the odometry.
  for (const auto& answer : obstacles.all) {
    if (answer->header.stamp < ros::Time(topics.stamp(0.0))) continue;
    const double t = answer->header.stamp.toSec() - topics.stamp(0.0);
    EXPECT_EQ(answer->view.odom_frame, "odom");
    EXPECT_NEAR(answer->view.pose.x, topics.robot.pose(t).x, 2e-4);
    EXPECT_NEAR(answer->view.pose.y, topics.robot.pose(t).y, 2e-4);
  }
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "localiser_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
