// Wheels that slip count six per cent too much, and in the middle of the drive they begin at zero
// again: with tf from map to odom the robot stays on its way, and the obstacle in its place in the
// map.

#include <gtest/gtest.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>

#include "box_in_map.hpp"
#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

constexpr int frames = 44, reset_at = 32;
constexpr double speed = 0.25, scale = 1.06;  // m/s; odometry's way over the true one
constexpr double tolerance = 0.2;            // s: what tf is dated into the future by

SE2 truth(double t) { return {speed * t, 0.0, 0.0}; }
/// What the wheels say, from the moment at which they began to count.
SE2 wheels(double t) {
  const bool anew = t > SyntheticRobot::frameTime(reset_at) - 1e-3;
  return {scale * speed * (t - (anew ? SyntheticRobot::frameTime(reset_at) : 0.0)), 0.0, 0.0};
}

class FloorLocaliser : public testing::Test {
 protected:
  FloorLocaliser()
      : tf_(node_, "/tf"),
        map_(node_, "/camera/map"),
        by_wheels_(node_, "/wheels/map"),
        obstacles_(node_, "/camera/obstacles"),
        topics_(node_) {}

  void drive() {
    for (int i = 0; i < frames; ++i) {
      const double t = topics_.robot.frameTime(i);
      topics_.sendInfo(t);
      topics_.sendImage(topics_.robot.image(topics_.stamp(t), truth(t)));
      for (int k = 5 * i; k < 5 * (i + 1); ++k) sendOdometry(topics_.robot.odometryTime(k));
      ros::spinOnce();
    }
    sendOdometry(topics_.robot.frameTime(frames));
  }
  void sendOdometry(double t) {
    topics_.sendOdometry(topics_.robot.odometry(topics_.stamp(t), wheels(t)));
  }
  [[nodiscard]] double end() const { return topics_.stamp(topics_.robot.frameTime(frames - 1)); }
  [[nodiscard]] bool arrived() const {
    const auto at = [&](const auto& header, double later) {
      return std::abs(header.stamp.toSec() - end() - later) < 1e-3;
    };
    return tf_.size() > 0 && at(tf_.last().transforms[0].header, tolerance) && map_.size() > 0 &&
           at(map_.last().header, 0.0) && at(by_wheels_.last().header, 0.0);
  }

  ros::NodeHandle node_;
  Collected<tf2_msgs::TFMessage> tf_;
  Collected<nav_msgs::OccupancyGrid> map_, by_wheels_;
  Collected<ObstacleArray> obstacles_;
  RobotTopics topics_;
};

TEST_F(FloorLocaliser, KeepsRobotAndObstacleInTheirPlaces) {
  topics_.tellTf();
  ASSERT_TRUE(waitForPublishers(tf_, map_, by_wheels_, obstacles_));
  ASSERT_TRUE(topics_.waitForListeners());
  drive();
  ASSERT_TRUE(waitFor([&] { return arrived(); }));

  int after_the_reset = 0;
  for (const auto& message : tf_.all) {
    ASSERT_EQ(message->transforms.size(), 1U);
    const auto& transform = message->transforms[0];
    EXPECT_EQ(transform.header.frame_id, "map");
    EXPECT_EQ(transform.child_frame_id, "odom");
    const double t = transform.header.stamp.toSec() - tolerance - topics_.stamp(0.0);
    const auto& q = transform.transform.rotation;
    const SE2 T_map_odom{transform.transform.translation.x, transform.transform.translation.y,
                         2.0 * std::atan2(q.z, q.w)};
    const SE2 robot = T_map_odom * wheels(t);
    EXPECT_NEAR(robot.x, truth(t).x, 0.025) << "at " << t;
    EXPECT_NEAR(robot.y, truth(t).y, 0.015) << "at " << t;
    EXPECT_NEAR(robot.theta, truth(t).theta, 0.02) << "at " << t;
    after_the_reset += t > topics_.robot.frameTime(reset_at);
  }
  EXPECT_GT(after_the_reset, 5);
  ASSERT_GT((scale - 1.0) * truth(topics_.robot.frameTime(frames - 1)).x, 0.06) << "by wheels";

  const Occupied seen(map_.last()), by_wheels(by_wheels_.last());
  EXPECT_EQ(map_.last().header.frame_id, "map");
  EXPECT_GE(seen.on_the_front, 6) << "the front of the box is eight cells wide";
  EXPECT_LT(seen.farthest, 0.08);
  EXPECT_GT(by_wheels.farthest, 0.5) << "otherwise this test could not tell";
  for (const auto& answer : obstacles_.all) {  // in the wheels' frame, for tf to move
    const double t = answer->header.stamp.toSec() - topics_.stamp(0.0);
    EXPECT_EQ(answer->view.odom_frame, "odom");
    EXPECT_NEAR(answer->view.pose.x, wheels(t).x, 2e-4);
  }
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "floor_localiser_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
