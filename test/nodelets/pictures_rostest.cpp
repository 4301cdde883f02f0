// The sweep's pictures for people: made only while somebody looks, and then they are what the
// detector of this sequence holds.

#include <gtest/gtest.h>

#include <memory>

#include "chain_client.hpp"
#include "ipm_mapping/frame_gate.hpp"
#include "ipm_mapping/parameters.hpp"
#include "ipm_mapping/ros/detector_pictures.hpp"
#include "ipm_mapping/ros/poses.hpp"
#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping {
namespace {

using Pictures = Collected<sensor_msgs::Image>;

/// The same two passes in this process: pictures after the frames that were used, differences from
/// the first pass, scores from the second.
struct Expected {
  std::vector<Image<std::uint8_t>> difference, score;

  explicit Expected(const SyntheticRobot& robot) {
    const Parameters parameters;
    sweep::SweepDetector detector(parameters.sweep);
    detector.setCamera(CameraModel(robot.intrinsics(), {}), robot.T_base_camera());
    pass(robot, detector, [&] { return differencePicture(detector, difference.emplace_back()); });
    detector.reset();
    const double cap = parameters.sweep.selection.score_cap;
    pass(robot, detector, [&] { return scorePicture(detector, cap, score.emplace_back()); });
  }

 private:
  template <class Take>
  static void pass(const SyntheticRobot& robot, Detector& detector, Take&& take) {
    FrameGate<sensor_msgs::ImagePtr> gate({}, 1000);
    const auto stamp = [&](double t) { return ros::Time(robot.first_stamp + t).toSec(); };
    for (int k = 0; k <= 5 * robot.frames; ++k) {
      const double t = robot.odometryTime(k);
      if (k % 5 == 0 && k < 5 * robot.frames)
        gate.addFrame(stamp(t), robot.image(robot.first_stamp + t, robot.pose(t)));
      gate.addOdometry(stamp(t), toSE2(robot.odometry(0, robot.pose(t)).pose.pose));
    }
    Obstacles answer;
    FrameGate<sensor_msgs::ImagePtr>::Released frame;
    for (std::uint64_t index = 0; gate.next(frame); ++index) {
      const GrayView view(frame.payload->data.data(), robot.width, robot.height);
      const FrameStatus status =
          detector.process({index, frame.stamp, view, frame.T_odom_base}, answer);
      if (status != FrameStatus::Used) continue;
      EXPECT_TRUE(take());
    }
  }
};

void expectSame(const Pictures& got, const std::vector<Image<std::uint8_t>>& expected) {
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    const sensor_msgs::Image& picture = *got.all[i];
    EXPECT_EQ(picture.encoding, "mono8");
    ASSERT_EQ(picture.width, static_cast<std::uint32_t>(expected[i].width()));
    ASSERT_EQ(picture.height, static_cast<std::uint32_t>(expected[i].height()));
    int farthest = 0;
    std::size_t different = 0;
    for (int v = 0; v < expected[i].height(); ++v)
      for (int u = 0; u < expected[i].width(); ++u) {
        const int got_here =
            picture.data[static_cast<std::size_t>(v) * picture.step + static_cast<std::size_t>(u)];
        const int away = std::abs(got_here - int{expected[i].at(u, v)});
        farthest = std::max(farthest, away);
        different += away > 0;
      }
    EXPECT_EQ(farthest, 0) << "picture " << i << ": " << different << " pixels differ";
  }
}

int brightest(const Image<std::uint8_t>& picture) {
  int most = 0;
  for (int v = 0; v < picture.height(); ++v)
    for (int u = 0; u < picture.width(); ++u) most = std::max(most, int{picture.at(u, v)});
  return most;
}

TEST(Pictures, AreMadeWhileSomebodyLooksAndTheDetectorSleepsOtherwise) {
  ros::NodeHandle node;
  RobotTopics topics(node);
  const Expected expected(topics.robot);
  ASSERT_GE(expected.score.size(), 10U);
  EXPECT_GT(brightest(expected.score.back()), 50) << "the box has to score";
  EXPECT_GT(brightest(expected.difference.back()), 10);
  topics.tellTf();
  waitFor([] { return false; }, 1.0);
  EXPECT_EQ(topics.listeners(), 0) << "nobody looks";

  auto difference = std::make_unique<Pictures>(node, "difference_image");
  ASSERT_TRUE(waitForPublishers(*difference));
  ASSERT_TRUE(topics.waitForListeners()) << "a look at the difference wakes the detector";
  topics.play(0, topics.robot.frames);
  waitFor([&] { return difference->size() >= expected.difference.size(); });
  expectSame(*difference, expected.difference);

  difference.reset();
  ASSERT_TRUE(waitFor([&] { return topics.listeners() == 0; })) << "nobody looks any more";
  const Pictures score(node, "score_image");
  ASSERT_TRUE(waitForPublishers(score));
  ASSERT_TRUE(topics.waitForListeners()) << "and so does a look at the scores";
  topics.play(0, topics.robot.frames);
  waitFor([&] { return score.size() >= expected.score.size(); });
  expectSame(score, expected.score);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "pictures_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
