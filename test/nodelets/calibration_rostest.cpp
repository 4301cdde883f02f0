// A camera that looks one degree higher than the nodelets are told, while the robot drives over a
// mottled floor: `apply` finds the pitch and works with it, `report` says so and leaves the answer
// alone, `off` does nothing. What was learnt outlives parameters that are changed live.

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <rosgraph_msgs/Log.h>

#include <cmath>
#include <memory>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

constexpr double degree = M_PI / 180.0;
constexpr double true_pitch = 0.42, stated_pitch = 0.43745;  // rad; the latter in the .test file
constexpr int half_way = 50, patience = 40;                  // frames

/// What an answer says about the camera.
double pitchOf(const ObstacleArray& answer) { return std::asin(-answer.view.camera[10]); }

class Calibration : public testing::Test {
 protected:
  Calibration()
      : diagnostics_(node_),
        off_(node_, "/off/obstacles"),
        apply_(node_, "/apply/obstacles"),
        switched_(node_, "/switched/obstacles"),
        console_(node_, "/rosout"),
        topics_(node_) {}

  void SetUp() override {
    topics_.tellTf();
    ASSERT_TRUE(waitForPublishers(off_, apply_, switched_));
    ASSERT_TRUE(topics_.waitForListeners());
    ASSERT_TRUE(waitFor([&] { return topics_.listeners() >= 3; }));
  }

  /// A slalom beside the box, over five metres.
  [[nodiscard]] static SE2 pose(double t) {
    return {0.53 * t, -2.0 - 0.1 * std::cos(1.5 * t), 0.28 * std::sin(1.5 * t)};
  }
  void drive(int from, int to) {
    for (int i = from; i < to; ++i) {
      const double t = topics_.robot.frameTime(i);
      topics_.sendInfo(t);
      topics_.sendImage(topics_.robot.image(topics_.stamp(t), pose(t)));
      for (int k = 0; k < 5; ++k) sendOdometry(t + k * topics_.robot.odometry_period);
      ros::spinOnce();
    }
    sendOdometry(topics_.robot.frameTime(to));
  }
  void sendOdometry(double t) {
    topics_.sendOdometry(topics_.robot.odometry(topics_.stamp(t), pose(t)));
  }
  [[nodiscard]] bool answered(int frame) const {
    const auto at = [&](const auto& topic) {
      return topic.size() > 0 && static_cast<int>(topic.last().frame) == frame;
    };
    return waitFor([&] { return at(off_) && at(apply_) && at(switched_); });
  }

  /// It has asked for another pitch, as a warning.
  [[nodiscard]] bool warned(const std::string& nodelet) {
    for (const auto& [sentence, level] : diagnostics_.sentences[nodelet])
      if (level == diagnostic_msgs::DiagnosticStatus::WARN &&
          sentence.find("higher than stated: change the pitch from 0.4374") != std::string::npos)
        return true;
    return false;
  }
  /// The same once on the console, where people look.
  [[nodiscard]] std::size_t saidOnTheConsole(const std::string& nodelet) const {
    std::size_t times = 0;
    for (const auto& message : console_.all)
      if (message->level == rosgraph_msgs::Log::WARN &&
          message->msg.find(nodelet) != std::string::npos &&
          message->msg.find("than stated: change the pitch") != std::string::npos)
        ++times;
    return times;
  }
  [[nodiscard]] static bool switchToApply() {
    dynamic_reconfigure::Reconfigure request;
    request.request.config.strs.resize(1);
    request.request.config.strs[0].name = "calibration/mode";
    request.request.config.strs[0].value = "apply";
    return ros::service::call("/switched/detector/set_parameters", request);
  }
  [[nodiscard]] static bool changeTheSweep() {
    dynamic_reconfigure::Reconfigure request;
    request.request.config.doubles.resize(1);
    request.request.config.doubles[0].name = "sweep/max_range";
    request.request.config.doubles[0].value = 1.5;
    return ros::service::call("/apply/detector/set_parameters", request);
  }
  /// All answers from the `first` one on are made with the true pitch.
  static void expectTruePitch(const Collected<ObstacleArray>& answers, std::size_t first) {
    EXPECT_GT(answers.size(), first);
    for (std::size_t i = first; i < answers.size(); ++i)
      EXPECT_NEAR(pitchOf(*answers.all[i]), true_pitch, 0.25 * degree)
          << "frame " << answers.all[i]->frame;
  }

  ros::NodeHandle node_;
  Diagnostics diagnostics_;
  Collected<ObstacleArray> off_, apply_, switched_;
  Collected<rosgraph_msgs::Log> console_;
  RobotTopics topics_;
};

void expectSameAnswer(const ObstacleArray& a, const ObstacleArray& b) {
  ASSERT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.view.camera, b.view.camera);
  ASSERT_EQ(a.bearings.size(), b.bearings.size());
  for (std::size_t i = 0; i < a.bearings.size(); ++i) {
    EXPECT_EQ(a.bearings[i].state, b.bearings[i].state) << "frame " << a.frame;
    EXPECT_EQ(a.bearings[i].range, b.bearings[i].range) << "frame " << a.frame;
  }
}

TEST_F(Calibration, ApplyRecoversThePitchReportTellsItAndOffDoesNothing) {
  drive(0, half_way);
  ASSERT_TRUE(answered(half_way - 1));
  const std::size_t reported = switched_.size();
  ASSERT_EQ(reported, off_.size());
  for (std::size_t i = 0; i < reported; ++i) expectSameAnswer(*off_.all[i], *switched_.all[i]);

  const std::string reporter = "switched/detector";
  EXPECT_TRUE(waitFor([&] {
    return std::abs(diagnostics_.value(reporter, "calibration_pitch_deg") * degree - true_pitch) <
           0.25 * degree;
  })) << diagnostics_.value(reporter, "calibration_pitch_deg");
  EXPECT_EQ(diagnostics_.value(reporter, "calibration_applied"), 0.0);

  int frame = half_way;
  while (!warned(reporter) && frame < half_way + patience) {
    drive(frame, frame + 1);
    ++frame;
    waitFor([&] { return warned(reporter); }, 0.1);
  }
  EXPECT_TRUE(warned(reporter));
  EXPECT_FALSE(warned("off/detector"));
  EXPECT_TRUE(waitFor([&] { return saidOnTheConsole("switched") > 0; }));
  EXPECT_EQ(saidOnTheConsole("off/detector"), 0U);

  ASSERT_TRUE(answered(frame - 1));
  const std::size_t answers_before[2] = {apply_.size(), switched_.size()};
  ASSERT_TRUE(switchToApply() && changeTheSweep());
  const int end_of_drive = frame + half_way;
  drive(frame, end_of_drive);
  ASSERT_TRUE(answered(end_of_drive - 1));
  for (const auto& answer : off_.all) EXPECT_NEAR(pitchOf(*answer), stated_pitch, 1e-9);
  EXPECT_NEAR(pitchOf(*apply_.all.front()), stated_pitch, 1e-9);
  expectTruePitch(apply_, answers_before[0]);
  expectTruePitch(switched_, answers_before[1]);
  EXPECT_NEAR(apply_.last().max_range, 1.5, 1e-6);

  for (const char* nodelet : {"apply/detector", "switched/detector"}) {
    EXPECT_TRUE(diagnostics_.waitFor(nodelet, "calibration_applied", 1.0)) << nodelet;
    EXPECT_NEAR(diagnostics_.value(nodelet, "calibration_pitch_deg") * degree, true_pitch,
                0.25 * degree);
  }
  EXPECT_GT(diagnostics_.value("off/detector", "used"), 0.0);
  EXPECT_EQ(diagnostics_.value("off/detector", "calibration_applied"), -1.0);
  EXPECT_EQ(diagnostics_.value("off/detector", "calibration_pitch_deg"), -1.0);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "calibration_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
