// Where a frame's pose comes from: the topic or tf, at the image's stamp moved by
// image_time_offset, however late odometry arrives behind the images. The overlay of the last
// nodelet finds the picture to that stamp, also after the offset was changed live.

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <rosgraph_msgs/Log.h>

#include <algorithm>

#include "chain_client.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"

namespace ipm_mapping {
namespace {

constexpr double launched_offset = 0.05;  // image_time_offset in the .test file

class Sources : public testing::Test {
 protected:
  Sources()
      : diagnostics_(node_),
        by_topic_(node_, "/by_topic/obstacles"),
        by_tf_(node_, "/by_tf/obstacles"),
        overlays_(node_, "/by_topic/overlay"),
        console_(node_, "/rosout"),
        tf_(node_.advertise<tf2_msgs::TFMessage>("/tf", 1000)),
        topics_(node_) {}

  void SetUp() override {
    // Every test has its own stretch of time: nothing of the one before reaches into it.
    static double shift = 0.0;
    topics_.time_shift = shift += 1000.0;
    topics_.tellTf();
    ASSERT_TRUE(waitForPublishers(by_topic_, by_tf_, overlays_));
    ASSERT_TRUE(topics_.waitForListeners());
    ASSERT_TRUE(waitFor([&] { return topics_.listeners() >= 2 && tf_.getNumSubscribers() >= 1; }));
    ASSERT_TRUE(waitFor([&] { return diagnostics_.value("ipm", "input_rate_hz") >= 0.0; }));
  }

  void TearDown() override {
    if (offset_ == launched_offset) return;
    ASSERT_TRUE(changeOffset(launched_offset));
  }

  [[nodiscard]] bool changeOffset(double seconds) {
    offset_ = seconds;
    dynamic_reconfigure::Reconfigure change;
    auto& wish = change.request.config.doubles.emplace_back();
    wish.name = "camera/image_time_offset";
    wish.value = seconds;
    return ros::service::call("/by_topic/ipm/set_parameters", change);
  }
  /// The picture of the instant t, its stamp the offset too early.
  [[nodiscard]] sensor_msgs::ImagePtr imageOf(double t) const {
    return topics_.robot.image(topics_.stamp(t) - offset_, topics_.robot.pose(t));
  }
  [[nodiscard]] bool said(const std::string& words) const {
    return std::any_of(console_.all.begin(), console_.all.end(), [&](const auto& message) {
      return message->msg.find(words) != std::string::npos;
    });
  }
  void sendTransform(double t) {
    const SE2 pose = topics_.robot.pose(t);
    geometry_msgs::TransformStamped transform;
    transform.header.stamp.fromSec(topics_.stamp(t));
    transform.header.frame_id = topics_.robot.odom_frame;
    transform.child_frame_id = topics_.robot.base_frame;
    transform.transform.translation.x = pose.x;
    transform.transform.translation.y = pose.y;
    transform.transform.rotation.z = std::sin(0.5 * pose.theta);
    transform.transform.rotation.w = std::cos(0.5 * pose.theta);
    tf2_msgs::TFMessage message;
    message.transforms.push_back(transform);
    tf_.publish(message);
  }
  /// Images between the odometry messages, so that poses have to be interpolated.
  [[nodiscard]] double frameTime(int i) const { return topics_.robot.frameTime(i) + 0.007; }

  /// Frames `from` ... `to` - 1, and odometry that reaches beyond them.
  void play(int from, int to) {
    for (int i = from; i < to; ++i) {
      topics_.sendInfo(frameTime(i));
      topics_.sendImage(imageOf(frameTime(i)));
      for (int k = 5 * i; k < 5 * (i + 1); ++k) {
        topics_.sendOdometry(topics_.robot.odometryTime(k));
        sendTransform(topics_.robot.odometryTime(k));
      }
      waitFor([] { return false; }, 0.05);
    }
    topics_.sendOdometry(topics_.robot.frameTime(to));
    sendTransform(topics_.robot.frameTime(to));
  }

  /// Every answer carries the instant at which its picture was taken, and the robot's pose of then.
  void expectTruePoses(const Collected<ObstacleArray>& answers) {
    for (const auto& answer : answers.all) {
      const double t = frameTime(static_cast<int>(answer->frame));
      EXPECT_NEAR(answer->header.stamp.toSec(), topics_.stamp(t), 1e-6);
      const SE2 pose = topics_.robot.pose(t);
      EXPECT_NEAR(answer->view.pose.x, pose.x, 2e-4) << "frame " << answer->frame;
      EXPECT_NEAR(answer->view.pose.y, pose.y, 2e-4);
      EXPECT_NEAR(answer->view.pose.theta, pose.theta, 2e-4);
    }
  }

  ros::NodeHandle node_;
  Diagnostics diagnostics_;
  Collected<ObstacleArray> by_topic_, by_tf_;
  Collected<sensor_msgs::Image> overlays_;
  Collected<rosgraph_msgs::Log> console_;
  ros::Publisher tf_;
  RobotTopics topics_;
  double offset_ = launched_offset;  // between the stamps of images and the truth
};

TEST_F(Sources, PosesFromTopicAndTfAreThoseOfTheMovedStamps) {
  play(0, topics_.robot.frames);
  EXPECT_TRUE(waitFor([&] { return by_topic_.size() >= 10 && by_tf_.size() >= 10; }))
      << by_topic_.size() << " answers by the topic, " << by_tf_.size() << " by tf";
  expectTruePoses(by_topic_);
  expectTruePoses(by_tf_);
  EXPECT_TRUE(waitFor([&] { return overlays_.size() > 0; }, 5.0))
      << "the overlay looks for pictures whose stamps were not moved";
}

/// As when a bag begins anew: tf takes nothing older than what it has seen.
TEST_F(Sources, PosesFromTfGoOnWhenTheirTimeIsSetBack) {
  play(0, topics_.robot.frames);
  ASSERT_TRUE(waitFor([&] { return by_tf_.size() >= 10; }));
  const std::size_t before = by_tf_.size();
  topics_.time_shift -= 500.0;
  play(0, topics_.robot.frames);
  EXPECT_TRUE(waitFor([&] { return by_tf_.size() >= before + 10; })) << by_tf_.size() - before;
  EXPECT_LT(by_tf_.last().header.stamp.toSec(), topics_.stamp(100.0));
}

/// What is set live and has no effect, because the robot says it itself.
TEST_F(Sources, WhatTfAndCameraInfoOverrideIsSaid) {
  play(0, 15);
  ASSERT_TRUE(waitFor([&] { return by_topic_.size() > 0; }));
  const auto set = [](double height, const std::string& file) {
    dynamic_reconfigure::Reconfigure change;
    change.request.config.doubles.resize(1);
    change.request.config.doubles[0].name = "camera/z";
    change.request.config.doubles[0].value = height;
    change.request.config.strs.resize(1);
    change.request.config.strs[0].name = "camera/calibration_file";
    change.request.config.strs[0].value = file;
    return ros::service::call("/by_topic/ipm/set_parameters", change);
  };
  ASSERT_TRUE(set(0.6, "/another.yaml"));
  play(15, 20);
  EXPECT_TRUE(waitFor([&] { return said("camera/x ... roll have no effect while tf knows"); }));
  EXPECT_TRUE(waitFor([&] { return said("camera/calibration_file is not used"); }));
  ASSERT_TRUE(set(CameraParameters{}.z, ""));
}

TEST_F(Sources, TheOverlayFollowsAnOffsetThatIsChangedLive) {
  constexpr int change_at = 10;
  play(0, change_at);
  ASSERT_TRUE(waitFor([&] { return overlays_.size() > 0; }, 5.0));
  ASSERT_TRUE(changeOffset(0.08));
  play(change_at, topics_.robot.frames);
  const double last = topics_.stamp(frameTime(topics_.robot.frames - 1));
  EXPECT_TRUE(
      waitFor([&] { return std::abs(overlays_.last().header.stamp.toSec() - last) < 1e-6; }, 5.0))
      << "the last overlay is " << last - overlays_.last().header.stamp.toSec() << " s old";
}

TEST_F(Sources, FramesOutliveOdometryThatArrivesAfterAllOfThem) {
  const double before = std::max(0.0, diagnostics_.value("ipm", "dropped_no_odometry"));
  const double used = std::max(0.0, diagnostics_.value("ipm", "used"));
  constexpr int frames = 40;  // four seconds: longer than odometry may stand still
  const auto received = diagnostics_.value("ipm", "received");
  std::vector<sensor_msgs::ImagePtr> images;
  for (int i = 0; i < frames; ++i) images.push_back(imageOf(frameTime(i)));
  topics_.sendInfo(0.0);
  for (const auto& image : images) topics_.sendImage(image);
  waitFor([] { return false; }, 0.2);
  for (int k = 0; k <= 5 * frames; ++k) topics_.sendOdometry(topics_.robot.odometryTime(k));
  EXPECT_TRUE(diagnostics_.waitFor("ipm", "received", received + frames));
  EXPECT_TRUE(waitFor([&] { return diagnostics_.value("ipm", "used") >= used + 10; }));
  EXPECT_EQ(std::max(0.0, diagnostics_.value("ipm", "dropped_no_odometry")), before);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "sources_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
