// What /diagnostics says while a robot drives and something is missing: the level changes, the
// sentence names what is missing, and all is well again when it is back.

#include <gtest/gtest.h>
#include <rosgraph_msgs/Log.h>
#include <sensor_msgs/CompressedImage.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

using diagnostic_msgs::DiagnosticStatus;

/// What of the robot works.
struct Feed {
  bool images = true, odometry = true, info = true;
  double image_time = 0.0, odometry_time = 0.0;  ///< seconds that stamps are off
  int spoilt = 0;                                ///< every so-many-th image is; 0: none
};

/// Nodelet, level and words of its sentence.
struct Expected {
  std::string nodelet;
  int level;
  std::string words;
};

class WhatDiagnosticsSay : public testing::Test {
 protected:
  WhatDiagnosticsSay() : diagnostics_(node_), console_(node_, "/rosout"), topics_(node_) {}

  void SetUp() override {
    topics_.tellTf();
    ASSERT_TRUE(topics_.waitForListeners());
    ASSERT_TRUE(waitFor([&] { return topics_.listeners() >= 2; }));
  }

  /// The robot drives on until all of this is said at once.
  void driveUntil(const Feed& feed, const std::vector<Expected>& expected) {
    const auto said = [&] {
      for (const Expected& each : expected)
        if (!diagnostics_.shows(each.nodelet, each.level, each.words)) return false;
      return true;
    };
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(40.0);
    while (!said() && ros::WallTime::now() < end) {
      step(feed);
      waitFor(said, 0.05);
    }
    EXPECT_TRUE(said());
    if (said()) return;
    for (const Expected& each : expected)
      ADD_FAILURE() << diagnostics_.status(each.nodelet) << "; expected: " << each.words;
  }
  [[nodiscard]] bool saidOnTheConsole(const std::string& nodelet, const std::string& words) const {
    return std::any_of(console_.all.begin(), console_.all.end(), [&](const auto& message) {
      return message->msg.find(nodelet) != std::string::npos &&
             message->msg.find(words) != std::string::npos;
    });
  }
  void driveUntilAllIsWell() {
    std::vector<Expected> well;
    for (const char* nodelet : {"piece/detector", "piece/mapper", "chain/ipm", "chain/segmentation",
                                "chain/localization", "chain/mapper"})
      well.push_back({nodelet, DiagnosticStatus::OK, "frames are used"});
    driveUntil(Feed{}, well);
  }

  /// What both instances' first nodelets say when frames are lost, and then the later ones.
  static std::vector<Expected> lost(int level, const std::string& words) {
    std::vector<Expected> all = {{"piece/detector", level, words}, {"chain/ipm", level, words}};
    for (const auto& [nodelet, topic] : {std::pair{"piece/mapper", "/piece/obstacles"},
                                         {"chain/segmentation", "/chain/difference"},
                                         {"chain/localization", "/chain/mask"},
                                         {"chain/mapper", "/chain/obstacles"}})
      all.push_back({nodelet, DiagnosticStatus::WARN, std::string("nothing comes in on ") + topic});
    return all;
  }

 private:
  /// Round and round, far from the box.
  [[nodiscard]] static SE2 pose(double t) {
    constexpr double radius = 1.5, turn_rate = 0.35;
    const double angle = turn_rate * t;
    return {radius * std::sin(angle), -5.0 - radius * std::cos(angle),
            std::remainder(angle, 2 * M_PI)};
  }
  void step(const Feed& feed) {
    const double t = topics_.robot.frameTime(frame++);
    if (feed.info) topics_.sendInfo(t);
    if (feed.images) sendImage(t, feed);
    for (int k = 0; feed.odometry && k < 5; ++k) {
      const double now = t + k * topics_.robot.odometry_period;
      topics_.sendOdometry(
          topics_.robot.odometry(topics_.stamp(now) + feed.odometry_time, pose(now)));
    }
  }
  void sendImage(double t, const Feed& feed) {
    const auto image = topics_.robot.image(topics_.stamp(t) + feed.image_time, pose(t));
    if (feed.spoilt > 0 && frame % feed.spoilt == 0) image->encoding = "32FC1";
    topics_.sendImage(image);
  }

  static int frame;  // the clock goes on from test to test
  ros::NodeHandle node_;
  Diagnostics diagnostics_;
  Collected<rosgraph_msgs::Log> console_;
  RobotTopics topics_;
};
int WhatDiagnosticsSay::frame = 0;

/// A wrong topic, as a rule.
TEST_F(WhatDiagnosticsSay, NothingEverComes) {
  // somebody sends them, but in another form
  const ros::Publisher compressed =
      ros::NodeHandle().advertise<sensor_msgs::CompressedImage>("/robot/image_raw/compressed", 1);
  EXPECT_TRUE(waitFor(
      [&] {
        return saidOnTheConsole("piece/detector",
                                "nothing comes in on /robot/image_raw: set image_transport to "
                                "compressed") &&
               saidOnTheConsole("chain/ipm", "nothing comes in on /robot/image_raw");
      },
      30.0));
  EXPECT_FALSE(saidOnTheConsole("mapper", "nothing comes in")) << "one sentence is enough";
  Feed feed;
  feed.info = feed.odometry = false;
  driveUntil(feed, lost(DiagnosticStatus::ERROR, "no odometry comes in on /robot/odom"));
}

TEST_F(WhatDiagnosticsSay, NoCalibrationAtTheStart) {
  Feed feed;
  feed.info = false;
  driveUntil(feed, lost(DiagnosticStatus::ERROR, "no camera_info on /robot/camera_info"));
  driveUntilAllIsWell();
}

TEST_F(WhatDiagnosticsSay, ImagesStop) {
  driveUntilAllIsWell();
  Feed feed;
  feed.images = false;
  driveUntil(feed, lost(DiagnosticStatus::WARN, "nothing comes in on /robot/image_raw"));
  driveUntilAllIsWell();
}

TEST_F(WhatDiagnosticsSay, OdometryStops) {
  driveUntilAllIsWell();
  Feed feed;
  feed.odometry = false;
  driveUntil(feed, lost(DiagnosticStatus::ERROR,
                        "odometry on /robot/odom does not reach the images' stamps"));
  driveUntilAllIsWell();
}

TEST_F(WhatDiagnosticsSay, OdometryIsOlderThanTheImages) {
  driveUntilAllIsWell();
  Feed feed;
  feed.odometry_time = -100.0;
  driveUntil(feed,
             lost(DiagnosticStatus::ERROR, "too many images wait for odometry on /robot/odom"));
  driveUntilAllIsWell();
}

TEST_F(WhatDiagnosticsSay, ImagesAreOlderThanAllOdometry) {
  driveUntilAllIsWell();
  Feed feed;
  feed.image_time = -100.0;
  driveUntil(feed, lost(DiagnosticStatus::ERROR, "image older than all odometry on /robot/odom"));
  driveUntilAllIsWell();
}

TEST_F(WhatDiagnosticsSay, AllImagesAreSpoiltOrSome) {
  driveUntilAllIsWell();
  Feed feed;
  feed.spoilt = 1;
  driveUntil(feed, lost(DiagnosticStatus::ERROR, "32FC1"));
  feed.spoilt = 3;
  driveUntil(feed, {{"piece/detector", DiagnosticStatus::WARN, "32FC1"},
                    {"chain/ipm", DiagnosticStatus::WARN, "32FC1"},
                    {"piece/mapper", DiagnosticStatus::OK, "frames are used"},
                    {"chain/mapper", DiagnosticStatus::OK, "frames are used"}});
  driveUntilAllIsWell();
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "diagnostics_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
