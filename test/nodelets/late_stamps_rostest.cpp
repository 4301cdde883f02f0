// A camera whose driver stamps its images 60 ms late, on a robot that swings from side to side:
// after a while everything that is published carries the instant at which the images were taken,
// and the pose of then. No frame is lost on the way there, nor is an image that came before all
// odometry called lost.

#include <gtest/gtest.h>

#include <cmath>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

constexpr double late = 0.06, tolerance = 0.008;  // seconds
constexpr int frames = 60;
constexpr int early = 1;  // images before all odometry

SE2 pose(double t) { return {0.3 * t, -2.0 - 0.036 * std::cos(2.5 * t), 0.3 * std::sin(2.5 * t)}; }

/// Stamp of an answer after the instant at which its image was taken.
double offOf(const std_msgs::Header& header, const RobotTopics& topics, int frame) {
  return header.stamp.toSec() - topics.stamp(topics.robot.frameTime(frame));
}

TEST(LateStamps, AreFoundOutAndPutRight) {
  ros::NodeHandle node;
  Diagnostics diagnostics(node);
  Collected<ObstacleArray> obstacles(node, "/late/obstacles");
  Collected<sensor_msgs::LaserScan> scans(node, "/late/scan");
  RobotTopics topics(node);
  topics.tellTf();
  ASSERT_TRUE(waitForPublishers(obstacles, scans));
  ASSERT_TRUE(topics.waitForListeners());
  // All of them wait for camera_info, and are released at once.
  topics.sendImage(topics.robot.image(topics.stamp(-0.5), pose(0.0)));
  waitFor([] { return false; }, 0.3);
  for (int i = 0; i < frames; ++i) {
    const double t = topics.robot.frameTime(i);
    sensor_msgs::ImagePtr image = topics.robot.image(topics.stamp(t), pose(t));
    image->header.stamp = ros::Time(topics.stamp(t) + late);
    topics.sendImage(image);
    for (int k = 5 * i; k < 5 * (i + 1); ++k) {
      const double at = topics.robot.odometryTime(k);
      topics.sendOdometry(topics.robot.odometry(topics.stamp(at), pose(at)));
    }
    if (i < 2) waitFor([] { return false; }, 0.1);
    topics.sendInfo(topics.robot.cameraInfo(topics.stamp(t) + late));
    ros::spinOnce();
  }
  ASSERT_TRUE(waitFor([&] {
    return obstacles.size() > 0 && static_cast<int>(obstacles.last().frame) == frames - 1 + early &&
           scans.size() == obstacles.size();
  }));

  const ObstacleArray &first = *obstacles.all.front(), &last = obstacles.last();
  EXPECT_NEAR(offOf(first.header, topics, static_cast<int>(first.frame) - early), late, 1e-6);
  EXPECT_NEAR(offOf(last.header, topics, frames - 1), 0.0, tolerance);
  EXPECT_EQ(scans.last().header.stamp, last.header.stamp);
  for (std::size_t i = 1; i < obstacles.size(); ++i)
    EXPECT_GT(obstacles.all[i]->header.stamp, obstacles.all[i - 1]->header.stamp);

  const SE2 there = pose(topics.robot.frameTime(frames - 1));
  EXPECT_NEAR(last.view.pose.x, there.x, 0.3 * tolerance);
  EXPECT_NEAR(last.view.pose.y, there.y, 0.09 * tolerance);
  EXPECT_NEAR(last.view.pose.theta, there.theta, 0.75 * tolerance);

  const std::string detector = "detector";
  EXPECT_TRUE(waitFor([&] {
    return std::abs(diagnostics.value(detector, "calibration_time_offset_ms") + 1000.0 * late) <
           1000.0 * tolerance;
  })) << diagnostics.value(detector, "calibration_time_offset_ms");
  ASSERT_TRUE(diagnostics.waitFor("mapper", "received", static_cast<double>(obstacles.size())));
  for (const char* nodelet : {"detector", "mapper"})
    EXPECT_EQ(diagnostics.value(nodelet, "dropped_out_of_order"), -1.0) << nodelet;
  EXPECT_TRUE(diagnostics.waitFor(detector, "skipped_before_odometry", early));
  EXPECT_EQ(diagnostics.value(detector, "dropped_older_than_odometry"), -1.0);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "late_stamps_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
