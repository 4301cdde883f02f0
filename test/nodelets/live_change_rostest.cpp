// Parameters changed by dynamic_reconfigure in the middle of a drive: the next frame is the first
// one that has them, all of them at once, and no frame is lost.

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cmath>
#include <thread>
#include <vector>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

using dynamic_reconfigure::Config;

template <class Entries, class Value>
void wish(Entries& entries, const std::string& name, const Value& value) {
  auto& entry = entries.emplace_back();
  entry.name = name;
  entry.value = value;
}

[[nodiscard]] bool change(const std::string& nodelet, const Config& wishes) {
  dynamic_reconfigure::Reconfigure request;
  request.request.config = wishes;
  return ros::service::call(nodelet + "/set_parameters", request);
}

/// What one instance publishes, and which nodelet of it takes the parameters of the outputs.
struct Instance {
  Instance(ros::NodeHandle& node, const std::string& name, const std::string& last)
      : nodelet("/" + name + "/" + last),
        obstacles(node, "/" + name + "/obstacles"),
        scans(node, "/" + name + "/scan"),
        contacts(node, "/" + name + "/contacts"),
        free(node, "/" + name + "/free") {}

  [[nodiscard]] bool awake() const { return waitForPublishers(obstacles, scans, contacts, free); }
  /// All four topics have told of the frame with this stamp.
  [[nodiscard]] bool arrivedAt(double stamp) const {
    const auto at = [stamp](const auto& topic) {
      return topic.size() > 0 && std::abs(topic.last().header.stamp.toSec() - stamp) < 1e-3;
    };
    return at(obstacles) && at(scans) && at(contacts) && at(free);
  }

  std::string nodelet;
  Collected<ObstacleArray> obstacles;
  Collected<sensor_msgs::LaserScan> scans;
  Collected<sensor_msgs::PointCloud2> contacts, free;
};

class LiveChange : public testing::Test {
 protected:
  LiveChange()
      : diagnostics_(node_),
        sweep_(node_, "sweep", "detector"),
        chain_(node_, "chain", "localization"),
        refined_(node_, "/sweep/odom_refined"),
        topics_(node_) {}

  void SetUp() override {
    // Every test has its own stretch of time.
    static double shift = 0.0;
    topics_.time_shift = shift += 1000.0;
    topics_.tellTf();
    ASSERT_TRUE(sweep_.awake() && chain_.awake() && waitForPublishers(refined_));
    ASSERT_TRUE(topics_.waitForListeners());
    ASSERT_TRUE(waitFor([&] { return topics_.listeners() >= 2; }));
  }

  /// Which frame of this test a message tells of.
  template <class Message>
  [[nodiscard]] int frameOf(const Message& message) const {
    const double t = message.header.stamp.toSec() - topics_.stamp(0.0);
    return static_cast<int>(std::lround(t / topics_.robot.frame_period));
  }
  /// Both instances have answered everything up to this frame.
  [[nodiscard]] bool answered(int frame) const {
    const double stamp = topics_.stamp(topics_.robot.frameTime(frame));
    return waitFor([&] { return sweep_.arrivedAt(stamp) && chain_.arrivedAt(stamp); });
  }
  /// From its first answer to `last` there is one of every frame on every topic.
  void expectNoFrameLost(const Instance& instance, int last) const {
    const int first = frameOf(*instance.obstacles.all.front());
    EXPECT_LT(first, 8);
    ASSERT_EQ(instance.obstacles.size(), static_cast<std::size_t>(last - first + 1));
    ASSERT_EQ(instance.scans.size(), instance.obstacles.size());
    ASSERT_EQ(instance.contacts.size(), instance.obstacles.size());
    ASSERT_EQ(instance.free.size(), instance.obstacles.size());
    for (std::size_t i = 0; i < instance.obstacles.size(); ++i)
      EXPECT_EQ(frameOf(*instance.obstacles.all[i]), first + static_cast<int>(i));
  }

  static Config outputs(double contact_z, double scan_range_max) {
    Config config;
    wish(config.doubles, "output/contact_z", contact_z);
    wish(config.doubles, "output/scan_range_max", scan_range_max);
    return config;
  }
  /// Whether scan and clouds of one frame are those of these parameters, or nothing of them.
  static bool changed(const Instance& instance, std::size_t i, double contact_z, double range_max) {
    const bool scan = std::abs(instance.scans.all[i]->range_max - range_max) < 1e-6;
    std::size_t points = 0, risen = 0;
    for (const auto* topic : {&instance.contacts, &instance.free})
      for (sensor_msgs::PointCloud2ConstIterator<float> z(*topic->all[i], "z"); z != z.end(); ++z) {
        ++points;
        risen += std::abs(*z - contact_z) < 1e-6 ? 1U : 0U;
      }
    EXPECT_GT(points, 0U);
    EXPECT_EQ(risen, scan ? points : 0U) << "half of the change in answer " << i;
    return scan;
  }

  ros::NodeHandle node_;
  Diagnostics diagnostics_;
  Instance sweep_, chain_;
  Collected<nav_msgs::Odometry> refined_;
  RobotTopics topics_;
};

TEST_F(LiveChange, TheNextFrameIsPublishedWithTheNewOutputs) {
  constexpr int change_at = 12, end = 20;
  topics_.play(0, change_at);
  ASSERT_TRUE(answered(change_at - 1));
  for (const Instance* each : {&sweep_, &chain_})
    ASSERT_TRUE(change(each->nodelet, outputs(0.3, 1.25)));
  topics_.play(change_at, end);
  ASSERT_TRUE(answered(end - 1));
  for (const Instance* each : {&sweep_, &chain_}) {
    SCOPED_TRACE(each->nodelet);
    expectNoFrameLost(*each, end - 1);
    for (std::size_t i = 0; i < each->scans.size(); ++i)
      EXPECT_EQ(changed(*each, i, 0.3, 1.25), frameOf(*each->scans.all[i]) >= change_at);
  }
}

TEST_F(LiveChange, ComesWholeWhileFramesFlow) {
  constexpr int end = 20;
  topics_.play(0, 9);
  ASSERT_TRUE(answered(8));
  bool taken = false;
  std::thread operator_at_the_screen([&] {
    taken = change(sweep_.nodelet, outputs(0.5, 1.5)) && change(chain_.nodelet, outputs(0.5, 1.5));
  });
  topics_.play(9, end);
  operator_at_the_screen.join();
  ASSERT_TRUE(taken);
  topics_.play(end, end + 1);
  ASSERT_TRUE(answered(end));
  for (const Instance* each : {&sweep_, &chain_}) {
    SCOPED_TRACE(each->nodelet);
    expectNoFrameLost(*each, end);
    bool before = false;
    for (std::size_t i = 0; i < each->scans.size(); ++i) {
      const bool now = changed(*each, i, 0.5, 1.5);
      EXPECT_TRUE(now || !before) << "answer " << i << " is as it was before the change";
      before = now;
    }
    EXPECT_TRUE(before);
  }
}

TEST_F(LiveChange, AThresholdCountsFromTheNextFrameOn) {
  constexpr int change_at = 16, end = 22, threshold = 200;
  topics_.play(0, change_at);
  ASSERT_TRUE(answered(change_at - 1));
  Config config;
  wish(config.ints, "segmentation/min_threshold", threshold);
  ASSERT_TRUE(change("/chain/segmentation", config));
  topics_.play(change_at, end);
  ASSERT_TRUE(answered(end - 1));
  expectNoFrameLost(chain_, end - 1);
  std::size_t seen[2] = {0, 0};
  for (const auto& answer : chain_.obstacles.all) {
    const bool after = frameOf(*answer) >= change_at;
    EXPECT_EQ(answer->threshold == threshold, after) << "frame " << frameOf(*answer);
    seen[after ? 1 : 0] += answer->contacts.size();
  }
  EXPECT_GT(seen[0], 0U) << "the box has to be in view";
  EXPECT_EQ(seen[1], 0U);
}

TEST_F(LiveChange, ADetectorWithOtherParametersStartsAgainAndLosesNothingElse) {
  constexpr int change_at = 10, end = 24;
  constexpr double max_range = 1.5;
  topics_.play(0, change_at);
  ASSERT_TRUE(answered(change_at - 1));
  Config config;
  wish(config.doubles, "sweep/max_range", max_range);
  ASSERT_TRUE(change(sweep_.nodelet, config));
  topics_.play(change_at, end);
  ASSERT_TRUE(answered(end - 1));
  int with_the_new = 0;
  for (const auto& answer : sweep_.obstacles.all) {
    EXPECT_EQ(std::abs(answer->max_range - max_range) < 1e-6, frameOf(*answer) >= change_at);
    with_the_new += frameOf(*answer) >= change_at;
  }
  EXPECT_GT(with_the_new, 3);
  EXPECT_EQ(frameOf(*sweep_.obstacles.all.back()), end - 1);
}

/// Wheels that say four per cent too much: what the floor has corrected stays corrected.
TEST_F(LiveChange, TheRefinedPoseDoesNotJump) {
  constexpr int change_at = 14, end = 28;
  const SyntheticRobot& robot = topics_.robot;
  const auto byWheels = [](double t) {
    SE2 pose = SyntheticRobot::pose(t);
    pose.x *= 1.04;
    return pose;
  };
  const auto play = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      topics_.sendInfo(robot.frameTime(i));
      topics_.sendImage(robot.frameTime(i));
      for (int k = 5 * i; k <= 5 * (i + 1); ++k) {
        const double t = robot.odometryTime(k);
        topics_.sendOdometry(robot.odometry(topics_.stamp(t), byWheels(t)));
      }
      ros::spinOnce();
    }
    return waitFor([&] { return refined_.size() > 0 && frameOf(refined_.last()) == to - 1; });
  };
  const auto errorOf = [&](const nav_msgs::Odometry& refined) {
    return refined.pose.pose.position.x - SyntheticRobot::pose(robot.frameTime(frameOf(refined))).x;
  };
  ASSERT_TRUE(play(0, change_at));
  const double before = errorOf(refined_.last());
  EXPECT_LT(before, byWheels(robot.frameTime(change_at - 1)).x -
                        SyntheticRobot::pose(robot.frameTime(change_at - 1)).x - 0.01)
      << "a jump to the wheels' pose would not show";
  Config config;
  wish(config.doubles, "sweep/max_range", 1.75);
  ASSERT_TRUE(change(sweep_.nodelet, config));
  ASSERT_TRUE(play(change_at, end));
  for (std::size_t i = 1; i < refined_.size(); ++i)
    EXPECT_NEAR(errorOf(*refined_.all[i]), errorOf(*refined_.all[i - 1]), 0.006)
        << "frame " << frameOf(*refined_.all[i]);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_change_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
