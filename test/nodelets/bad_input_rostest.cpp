// What is wrong with a message is said on /diagnostics, the message is dropped and counted, and the
// chain answers the good ones afterwards.

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

class BadInput : public testing::Test {
 protected:
  BadInput() : diagnostics_(node_), obstacles_(node_, "/camera/obstacles"), topics_(node_) {}

  void SetUp() override {
    // Every test has its own stretch of time: nothing of the one before reaches into it.
    static double shift = 0.0;
    topics_.time_shift = shift += 1000.0;
    ASSERT_TRUE(waitForPublishers(obstacles_));
    ASSERT_TRUE(topics_.waitForListeners());
    ASSERT_TRUE(waitFor([&] { return diagnostics_.value("ipm", "input_rate_hz") >= 0.0; }));
    diagnostics_.faults.clear();
  }

  /// A good sequence is answered as ever.
  void expectTheChainToWork() {
    const std::size_t before = obstacles_.size();
    topics_.time_shift += 100.0;
    topics_.play(0, topics_.robot.frames);
    EXPECT_TRUE(waitFor([&] { return obstacles_.size() >= before + 10; }))
        << obstacles_.size() - before << " answers";
  }

  /// How often a fault came whose sentence holds both words.
  [[nodiscard]] long faults(const std::string& nodelet, const std::string& a,
                            const std::string& b) {
    long count = 0;
    for (const auto& [sentence, times] : diagnostics_.faults[nodelet])
      if (sentence.find(a) != std::string::npos && sentence.find(b) != std::string::npos)
        count += times;
    return count;
  }
  [[nodiscard]] bool said(const std::string& nodelet, const std::string& a, const std::string& b) {
    return waitFor([&] { return faults(nodelet, a, b) > 0; });
  }
  [[nodiscard]] bool countsTo(const std::string& key, double before, double more) {
    return waitFor([&] { return diagnostics_.value("ipm", key) == std::max(0.0, before) + more; });
  }

  ros::NodeHandle node_;
  Diagnostics diagnostics_;
  Collected<ObstacleArray> obstacles_;
  RobotTopics topics_;
};

TEST_F(BadInput, MissingTfLeavesTheStatedCameraPose) { expectTheChainToWork(); }

TEST_F(BadInput, UnknownEncodingIsNamedAndCounted) {
  const double before = diagnostics_.value("ipm", "dropped_bad_image");
  topics_.sendInfo(0.0);
  for (int i = 0; i < 3; ++i) {
    auto image = topics_.robot.image(topics_.stamp(0.1 * i), topics_.robot.pose(0));
    image->encoding = "32FC1";
    topics_.sendImage(image);
  }
  for (int k = 0; k < 20; ++k) topics_.sendOdometry(0.02 * k);
  EXPECT_TRUE(countsTo("dropped_bad_image", before, 3));
  EXPECT_TRUE(said("ipm", "32FC1", "/robot/image_raw"));
  expectTheChainToWork();
}

TEST_F(BadInput, TruncatedImageIsNamedAndCounted) {
  const double before = diagnostics_.value("ipm", "dropped_bad_image");
  auto image = topics_.robot.image(topics_.stamp(0.0), topics_.robot.pose(0));
  image->data.resize(100);
  topics_.sendInfo(0.0);
  topics_.sendImage(image);
  for (int k = 0; k < 20; ++k) topics_.sendOdometry(0.02 * k);
  EXPECT_TRUE(countsTo("dropped_bad_image", before, 1));
  EXPECT_TRUE(said("ipm", "100 bytes", "data"));
  expectTheChainToWork();
}

TEST_F(BadInput, ZeroCalibrationIsNamedAndItsFramesAreCounted) {
  const double before = diagnostics_.value("ipm", "dropped_no_camera");
  auto info = topics_.robot.cameraInfo(topics_.stamp(0));
  info.K[0] = 0.0;
  topics_.sendInfo(info);
  ros::WallDuration(0.3).sleep();  // the calibration is there before the frames
  for (int i = 0; i < 30; ++i) topics_.sendImage(0.1 * i);
  for (int k = 0; k < 160; ++k) topics_.sendOdometry(0.02 * k);
  EXPECT_TRUE(countsTo("dropped_no_camera", before, 30));
  EXPECT_TRUE(said("ipm", "K[0] = 0", "/robot/camera_info"));
  expectTheChainToWork();
}

TEST_F(BadInput, ImageOfAnotherSizeIsNamedAndCounted) {
  const double before = diagnostics_.value("ipm", "dropped_size_mismatch");
  auto image = topics_.robot.image(topics_.stamp(0.0), topics_.robot.pose(0));
  image->height = 200;
  topics_.sendInfo(0.0);
  topics_.sendImage(image);
  for (int k = 0; k < 20; ++k) topics_.sendOdometry(0.02 * k);
  EXPECT_TRUE(countsTo("dropped_size_mismatch", before, 1));
  EXPECT_TRUE(said("ipm", "320x200", "320x240"));
  expectTheChainToWork();
}

TEST_F(BadInput, EveryFaultIsSaidHoweverManyComeAtOnce) {
  const auto image = [&](int i) {
    return topics_.robot.image(topics_.stamp(0.1 * i), topics_.robot.pose(0));
  };
  std::vector<sensor_msgs::ImagePtr> images;
  for (int i = 0; i < 4; ++i) images.push_back(image(i));
  images[0]->encoding = images[2]->encoding = "32FC1";
  images[1]->data.resize(100);
  images[3]->height = 200;
  topics_.sendInfo(0.0);
  for (const auto& each : images) topics_.sendImage(each);
  for (int k = 0; k < 30; ++k) topics_.sendOdometry(0.02 * k);
  EXPECT_TRUE(waitFor([&] { return faults("ipm", "320x200", "320x240") == 1; }));
  EXPECT_EQ(faults("ipm", "32FC1", "/robot/image_raw"), 2);
  EXPECT_EQ(faults("ipm", "100 bytes", "data"), 1);
  expectTheChainToWork();
}

TEST_F(BadInput, OdometryThatIsNotFiniteIsCountedAndLeavesNoTrace) {
  const double before = diagnostics_.value("ipm", "odometry_not_finite");
  const std::size_t answers = obstacles_.size();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < topics_.robot.frames; ++i) {
    topics_.play(i, i + 1);
    auto odometry = topics_.robot.odometry(topics_.stamp(0.1 * i + 0.09), SE2{nan, 0, 0});
    topics_.sendOdometry(odometry);
  }
  EXPECT_TRUE(countsTo("odometry_not_finite", before, topics_.robot.frames));
  EXPECT_TRUE(waitFor([&] { return obstacles_.size() >= answers + 10; }));
  for (const auto& message : obstacles_.all)
    EXPECT_TRUE(std::isfinite(message->view.pose.x) && std::isfinite(message->view.motion.x));
}

/// A driver that leaves the orientation as it is made: all zero.
TEST_F(BadInput, OdometryWithoutAnOrientationIsDroppedAndNamed) {
  const double before = diagnostics_.value("ipm", "odometry_not_finite");
  for (int k = 0; k < 10; ++k) {
    auto odometry = topics_.robot.odometry(topics_.stamp(0.02 * k), topics_.robot.pose(0));
    odometry.pose.pose.orientation = geometry_msgs::Quaternion();
    topics_.sendOdometry(odometry);
  }
  EXPECT_TRUE(countsTo("odometry_not_finite", before, 10));
  expectTheChainToWork();
}

TEST_F(BadInput, FramesWithoutOdometryAreCountedWithTheTopicsName) {
  const double before = diagnostics_.value("ipm", "dropped_no_odometry");
  topics_.sendInfo(0.0);
  for (int i = 0; i < 30; ++i) topics_.sendImage(1.0 * i);
  // Those that fell behind by more than the five seconds that odometry may lag here.
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_.value("ipm", "dropped_no_odometry") >= std::max(0.0, before) + 15;
  }));
  EXPECT_TRUE(said("ipm", "/robot/odom", "odometry"));
  expectTheChainToWork();
}

TEST_F(BadInput, LateImageIsDroppedAlone) {
  const double before = diagnostics_.value("ipm", "dropped_out_of_order");
  const std::size_t answers = obstacles_.size();
  topics_.play(0, 10);
  topics_.sendImage(0.5);
  for (int i = 10; i < 20; ++i) topics_.play(i, i + 1);
  EXPECT_TRUE(countsTo("dropped_out_of_order", before, 1));
  EXPECT_TRUE(waitFor([&] { return obstacles_.size() >= answers + 15; }));
  EXPECT_LE(diagnostics_.value("ipm", "resets"), 0.0);
}

TEST_F(BadInput, MessagesOfAStageThatContradictThemselvesAreDropped) {
  // The mapper listens, and so does this test.
  ros::Publisher answers = node_.advertise<ObstacleArray>("/camera/obstacles", 10);
  ASSERT_TRUE(waitFor([&] { return answers.getNumSubscribers() > 1; }));
  ObstacleArray nonsense;
  nonsense.header.stamp = ros::Time(topics_.stamp(0));
  answers.publish(nonsense);
  EXPECT_TRUE(waitFor([&] { return diagnostics_.value("mapper", "dropped_bad_obstacles") == 1; }));
  expectTheChainToWork();
}

TEST_F(BadInput, AnswersThatArriveTwiceCountOnce) {
  ros::Publisher answers = node_.advertise<ObstacleArray>("/camera/obstacles", 10);
  ASSERT_TRUE(waitFor([&] { return answers.getNumSubscribers() > 1; }));
  expectTheChainToWork();
  const ObstacleArrayConstPtr newest = obstacles_.all.back();
  EXPECT_TRUE(waitFor([&] { return diagnostics_.value("mapper", "used") >= 10; }));
  const double before = std::max(0.0, diagnostics_.value("mapper", "dropped_out_of_order"));
  answers.publish(newest);
  EXPECT_TRUE(waitFor(
      [&] { return diagnostics_.value("mapper", "dropped_out_of_order") == before + 1.0; }));
}

TEST_F(BadInput, ANodeletThatCannotStartIsAnErrorThatSaysWhy) {
  ASSERT_TRUE(waitFor([&] { return !diagnostics_.sentences["broken_mapper"].empty(); }));
  EXPECT_EQ(diagnostics_.level("broken_mapper"), diagnostic_msgs::DiagnosticStatus::ERROR);
  ASSERT_EQ(diagnostics_.sentences["broken_mapper"].size(), 1U);
  const std::string sentence = diagnostics_.sentences["broken_mapper"].begin()->first;
  EXPECT_NE(sentence.find("cannot start"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("resolution"), std::string::npos) << sentence;
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "bad_input_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
