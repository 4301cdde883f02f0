// launch/compare.launch from outside: the FPGA model's topics carry the bits of the staged datapath
// run here on the same frames, and the comparison says what its inputs say.

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <ipm_mapping/Comparison.h>
#include <ipm_mapping/DifferenceImage.h>
#include <ipm_mapping/FpgaReport.h>
#include <ipm_mapping/ObstacleMask.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>
#include <memory>
#include <sstream>

#include "chain_client.hpp"
#include "ipm_mapping/detectors/comparison.hpp"
#include "ipm_mapping/detectors/fpga_detector.hpp"
#include "ipm_mapping/fpga/cycles.hpp"
#include "ipm_mapping/fpga/vectors.hpp"
#include "ipm_mapping/frame_gate.hpp"
#include "ipm_mapping/ros/images.hpp"
#include "ipm_mapping/ros/poses.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {
namespace {

/// What a frame has to give, computed in this process by the readable engine.
struct Expected {
  int frame = 0;
  fpga::FrameSetup setup;
  fpga::Wires wires;
  std::size_t contacts = 0;
};

std::vector<Expected> expectedAnswers(const SyntheticRobot& robot) {
  FpgaDetector detector(Parameters::profile("paper"));
  detector.setCamera(CameraModel(robot.intrinsics(), {}),
                     tf2::transformToEigen(robot.cameraTransform()));
  FrameGate<sensor_msgs::ImagePtr> gate(Parameters{}.odometry, 1000);
  const auto stamp = [&](double t) { return ros::Time(robot.first_stamp + t).toSec(); };
  for (int k = 0; k <= 5 * robot.frames; ++k) {
    const double t = robot.odometryTime(k);
    if (k % 5 == 0 && k < 5 * robot.frames)
      gate.addFrame(stamp(t), robot.image(robot.first_stamp + t, robot.pose(t)));
    gate.addOdometry(stamp(t), toSE2(robot.odometry(0, robot.pose(t)).pose.pose));
  }
  std::vector<Expected> answers;
  FrameGate<sensor_msgs::ImagePtr>::Released frame;
  Obstacles obstacles;
  for (int index = 0; gate.next(frame); ++index) {
    const GrayView view(frame.payload->data.data(), robot.width, robot.height);
    const auto number = static_cast<std::uint64_t>(index);
    if (detector.process({number, frame.stamp, view, frame.T_odom_base}, obstacles) !=
        FrameStatus::Used)
      continue;
    Expected& answer = answers.emplace_back();
    answer.frame = index;
    answer.setup = detector.frameSetup();
    answer.contacts = obstacles.contacts.size();
    fpga::runAllWires({detector.reference(), view, answer.setup.parameters}, answer.wires,
                      fpga::Engine::Staged);
  }
  return answers;
}

class Compare : public testing::Test {
 protected:
  static void SetUpTestSuite() { played = play(); }
  /// What fails for the whole suite only skips its tests, and rostest calls them passed.
  void SetUp() override { ASSERT_TRUE(played); }

  /// Plays the sequence once, one frame after the other has been answered.
  static bool play() {
    node = std::make_unique<ros::NodeHandle>();
    topics = std::make_unique<RobotTopics>(*node);
    expected = expectedAnswers(topics->robot);
    if (expected.size() < 10) return false;
    Diagnostics diagnostics(*node);
    differences = std::make_unique<Collected<DifferenceImage>>(*node, "/camera/difference");
    masks = std::make_unique<Collected<ObstacleMask>>(*node, "/camera/mask");
    answers = std::make_unique<Collected<ObstacleArray>>(*node, "/camera/obstacles");
    fixed_differences =
        std::make_unique<Collected<DifferenceImage>>(*node, "/camera/fpga/difference");
    fixed_masks = std::make_unique<Collected<ObstacleMask>>(*node, "/camera/fpga/mask");
    fixed_answers = std::make_unique<Collected<ObstacleArray>>(*node, "/camera/fpga/obstacles");
    reports = std::make_unique<Collected<FpgaReport>>(*node, "/camera/fpga/report");
    comparisons = std::make_unique<Collected<Comparison>>(*node, "/camera/comparison");
    pictures =
        std::make_unique<Collected<sensor_msgs::Image>>(*node, "/camera/comparison/contacts");
    topics->tellTf();
    if (!everybodyAwake(diagnostics) ||
        !waitForPublishers(*differences, *masks, *answers, *fixed_differences, *fixed_masks,
                           *fixed_answers, *reports, *comparisons, *pictures) ||
        !topics->waitForListeners())
      return false;
    for (int i = 0; i < topics->robot.frames; ++i) {
      topics->play(i, i + 1);
      std::size_t due = 0;
      for (const Expected& each : expected) due += each.frame <= i;
      if (!waitFor([due] { return smallest() >= due; }, 20.0)) return false;
    }
    return waitFor([] { return pictures->size() > 0; }, 20.0);
  }
  static void TearDownTestSuite() {
    differences.reset(), masks.reset(), answers.reset(), fixed_differences.reset();
    fixed_masks.reset(), fixed_answers.reset(), reports.reset(), comparisons.reset();
    pictures.reset(), topics.reset(), node.reset();
  }

  /// Whoever waits for input complains about having none.
  static bool everybodyAwake(Diagnostics& diagnostics) {
    return waitFor(
        [&] {
          int awake = 0;
          for (const char* nodelet :
               {"ipm", "segmentation", "localization", "fpga_model", "comparator"})
            for (const auto& [sentence, level] : diagnostics.sentences[nodelet])
              awake += sentence.rfind("nothing comes in", 0) == 0;
          return awake >= 5;
        },
        60.0);
  }
  static std::size_t smallest() {
    return std::min({differences->size(), masks->size(), answers->size(), fixed_differences->size(),
                     fixed_masks->size(), fixed_answers->size(), reports->size(),
                     comparisons->size()});
  }

  static bool played;
  static std::unique_ptr<ros::NodeHandle> node;
  static std::unique_ptr<RobotTopics> topics;
  static std::vector<Expected> expected;
  static std::unique_ptr<Collected<DifferenceImage>> differences, fixed_differences;
  static std::unique_ptr<Collected<ObstacleMask>> masks, fixed_masks;
  static std::unique_ptr<Collected<ObstacleArray>> answers, fixed_answers;
  static std::unique_ptr<Collected<FpgaReport>> reports;
  static std::unique_ptr<Collected<Comparison>> comparisons;
  static std::unique_ptr<Collected<sensor_msgs::Image>> pictures;
};
bool Compare::played = false;
std::unique_ptr<ros::NodeHandle> Compare::node;
std::unique_ptr<RobotTopics> Compare::topics;
std::vector<Expected> Compare::expected;
std::unique_ptr<Collected<DifferenceImage>> Compare::differences, Compare::fixed_differences;
std::unique_ptr<Collected<ObstacleMask>> Compare::masks, Compare::fixed_masks;
std::unique_ptr<Collected<ObstacleArray>> Compare::answers, Compare::fixed_answers;
std::unique_ptr<Collected<FpgaReport>> Compare::reports;
std::unique_ptr<Collected<Comparison>> Compare::comparisons;
std::unique_ptr<Collected<sensor_msgs::Image>> Compare::pictures;

TEST_F(Compare, BothSidesAnswerTheSameFrames) {
  ASSERT_EQ(answers->size(), expected.size());
  ASSERT_EQ(fixed_answers->size(), expected.size());
  ASSERT_EQ(comparisons->size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const ros::Time stamp = answers->all[i]->header.stamp;
    EXPECT_EQ(static_cast<int>(answers->all[i]->frame), expected[i].frame);
    EXPECT_EQ(static_cast<int>(fixed_answers->all[i]->frame), expected[i].frame);
    EXPECT_EQ(fixed_answers->all[i]->header.stamp, stamp);
    EXPECT_EQ(fixed_differences->all[i]->header.stamp, stamp);
    EXPECT_EQ(fixed_masks->all[i]->header.stamp, stamp);
    EXPECT_EQ(reports->all[i]->header.stamp, stamp);
    EXPECT_EQ(comparisons->all[i]->header.stamp, stamp);
  }
}

TEST_F(Compare, TheModelsRegistersAreThoseOfTheSoftwarePart) {
  ASSERT_EQ(reports->size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::ostringstream text;
    for (const NamedInteger& r : reports->all[i]->registers)
      text << r.name << '=' << r.value << '\n';
    EXPECT_TRUE(fpga::parseParameters(text.str()) == expected[i].setup.parameters)
        << "answer " << i;
    EXPECT_EQ(reports->all[i]->homography_error_px, expected[i].setup.homography_error);
  }
}

TEST_F(Compare, TheDifferenceTopicCarriesTheWireBitForBit) {
  ASSERT_EQ(fixed_differences->size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    GrayView grey, valid;
    ASSERT_FALSE(wrap(*fixed_differences->all[i], grey, valid));
    int wrong = 0, seen = 0;
    for (int v = 0; v < grey.height; ++v)
      for (int u = 0; u < grey.width; ++u) {
        const fpga::TaggedPixel wire = expected[i].wires.difference.at(u, v);
        const bool tagged = (wire & fpga::no_correspondence) != 0;
        wrong += valid.at(u, v) != (tagged ? 0 : 255);
        wrong += grey.at(u, v) != (tagged ? 0 : wire);
        seen += !tagged;
      }
    EXPECT_EQ(wrong, 0) << "answer " << i;
    EXPECT_GT(seen, grey.width * grey.height / 4);
  }
}

TEST_F(Compare, TheMaskTopicCarriesTheErodedWireBitForBit) {
  ASSERT_EQ(fixed_masks->size(), expected.size());
  int obstacle_pixels = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    GrayView view;
    ASSERT_FALSE(wrap(*fixed_masks->all[i], view));
    const fpga::Wires& wires = expected[i].wires;
    int wrong = 0;
    for (int v = 0; v < view.height; ++v)
      for (int u = 0; u < view.width; ++u) {
        const bool unseen = (wires.gaussian.at(u, v) & fpga::no_correspondence) != 0;
        const int wanted = wires.eroded.at(u, v) != 0 ? mask::obstacle
                           : unseen                   ? mask::unseen
                                                      : mask::floor;
        wrong += view.at(u, v) != wanted;
        obstacle_pixels += wires.eroded.at(u, v);
      }
    EXPECT_EQ(wrong, 0) << "answer " << i;
  }
  EXPECT_GT(obstacle_pixels, 1000);
}

TEST_F(Compare, TheReportCarriesResultsCountersAndCycles) {
  ASSERT_EQ(reports->size(), expected.size());
  const FpgaClockParameters clock;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const FpgaReport& report = *reports->all[i];
    const fpga::Results& results = expected[i].wires.results;
    EXPECT_EQ(report.threshold_in, expected[i].setup.parameters.threshold_in);
    EXPECT_EQ(report.threshold_out, results.threshold_out);
    EXPECT_EQ(report.points, results.selected.size);
    ASSERT_EQ(report.overflow.size(), fpga::wire_count);
    for (std::size_t w = 0; w < fpga::wire_count; ++w) {
      EXPECT_EQ(report.overflow[w].name, fpga::wire_names[w]);
      EXPECT_EQ(report.overflow[w].value, static_cast<std::int64_t>(results.overflow.counts()[w]));
    }
    const auto activity =
        fpga::activityOf(results, static_cast<int>(expected[i].setup.parameters.min_height));
    const auto timing =
        fpga::frameTiming(clock, SyntheticRobot::width, SyntheticRobot::height, activity);
    EXPECT_EQ(report.cycles_to_first_contact, timing.first_contact);
    EXPECT_EQ(report.cycles_of_frame, SyntheticRobot::width * SyntheticRobot::height);
    EXPECT_EQ(report.cycles_to_last_point, report.cycles_of_frame + timing.after_last_pixel);
    EXPECT_NEAR(static_cast<double>(report.cycles_to_map), timing.to_map * clock.pixel_clock, 1.0);
    EXPECT_EQ(report.frame_rate, timing.frame_rate);
  }
}

TEST_F(Compare, TheComparisonSaysWhatItsInputsSay) {
  ASSERT_EQ(comparisons->size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Comparison& got = *comparisons->all[i];
    GrayView grey[2], valid[2], mask[2];
    Obstacles answer[2];
    ASSERT_FALSE(wrap(*differences->all[i], grey[0], valid[0]));
    ASSERT_FALSE(wrap(*fixed_differences->all[i], grey[1], valid[1]));
    ASSERT_FALSE(wrap(*masks->all[i], mask[0]));
    ASSERT_FALSE(wrap(*fixed_masks->all[i], mask[1]));
    ASSERT_FALSE(fromMessage(*answers->all[i], answer[0]));
    ASSERT_FALSE(fromMessage(*fixed_answers->all[i], answer[1]));
    const auto difference = compareDifferences(grey[0], valid[0], grey[1], valid[1]);
    const auto masked = compareMasks(mask[0], mask[1]);
    const auto points = compareContacts(answer[0].contacts, answer[1].contacts);
    EXPECT_EQ(got.difference.changed, difference.changed);
    EXPECT_EQ(got.difference.compared, difference.compared);
    EXPECT_EQ(got.difference.max, static_cast<float>(difference.max));
    EXPECT_EQ(got.difference.mean, static_cast<float>(difference.mean));
    EXPECT_EQ(got.mask.changed, masked.changed);
    EXPECT_EQ(got.mask.seen_once, masked.seen_once);
    EXPECT_EQ(got.contacts.points_float, points.points_a);
    EXPECT_EQ(got.contacts.points_fixed, points.points_b);
    EXPECT_EQ(got.threshold_float, masks->all[i]->threshold);
    EXPECT_EQ(got.threshold_fixed, fixed_masks->all[i]->threshold);
    if (!std::isnan(points.mean_distance)) {
      EXPECT_EQ(got.contacts.mean_distance, static_cast<float>(points.mean_distance));
    }
  }
}

TEST_F(Compare, FixedPointStaysCloseToFloat) {
  double mean = 0.0;
  for (const auto& each : comparisons->all) mean += each->difference.mean;
  EXPECT_LT(mean / static_cast<double>(comparisons->size()), 1.0);
  EXPECT_GT(mean, 0.0);
}

TEST_F(Compare, ThePictureShowsBothSidesAndWhatTheyShare) {
  const sensor_msgs::Image& picture = pictures->last();
  EXPECT_EQ(picture.encoding, "bgr8");
  EXPECT_GE(static_cast<int>(picture.width), 3 * SyntheticRobot::width);
  EXPECT_GT(static_cast<int>(picture.height), SyntheticRobot::height);
}

/// The last one: the drive goes on, with images that are stamped too early.
TEST_F(Compare, ThePictureFollowsAnOffsetThatIsChangedLive) {
  constexpr double offset = 0.02;
  dynamic_reconfigure::Reconfigure change;
  auto& wish = change.request.config.doubles.emplace_back();
  wish.name = "camera/image_time_offset";
  wish.value = offset;
  for (const char* nodelet : {"ipm", "fpga_model"})
    ASSERT_TRUE(ros::service::call(std::string("/camera/") + nodelet + "/set_parameters", change));
  const SyntheticRobot& robot = topics->robot;
  const int first = robot.frames, last = first + 11;
  for (int i = first; i <= last; ++i) {
    const double t = robot.frameTime(i);
    topics->sendInfo(t);
    topics->sendImage(robot.image(topics->stamp(t) - offset, robot.pose(t)));
    for (int k = 5 * i; k <= 5 * (i + 1); ++k) topics->sendOdometry(robot.odometryTime(k));
    waitFor([] { return false; }, 0.05);
  }
  const double newest = topics->stamp(robot.frameTime(last));
  EXPECT_TRUE(waitFor(
      [&] { return std::abs(pictures->last().header.stamp.toSec() - newest) < 1e-6; }, 20.0))
      << "the last picture is " << newest - pictures->last().header.stamp.toSec() << " s old";
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "compare_rostest");
  ros::NodeHandle alive;
  return RUN_ALL_TESTS();
}
