#include "ipm_mapping/ros/frame_faults.hpp"

#include <gtest/gtest.h>

#include <set>

#include "ipm_mapping/ros/offline_run.hpp"

namespace ipm_mapping {
namespace {

void count(RunReport& report, FrameStatus status, std::uint64_t frames) {
  report.frames[static_cast<std::size_t>(status)] = frames;
  report.images += frames;
}
void count(RunReport& report, GateDrop reason, std::uint64_t frames) {
  report.gate_drops[static_cast<std::size_t>(reason)] = frames;
  report.images += frames;
}

const BagTopics topics{"/image", "/camera_info", "/wheels"};

TEST(FrameFaults, EveryReasonHasANameAndWordsOfItsOwn) {
  std::set<std::string> names, words;
  for (int i = 0; i < frame_status_count; ++i) {
    names.insert(name(static_cast<FrameStatus>(i)));
    words.insert(explain(static_cast<FrameStatus>(i)));
  }
  for (int i = 0; i < gate_drop_count; ++i) {
    names.insert(name(static_cast<GateDrop>(i)));
    words.insert(explain(static_cast<GateDrop>(i), "/wheels"));
  }
  constexpr std::size_t reasons = frame_status_count + gate_drop_count;
  EXPECT_EQ(names.size(), reasons);
  EXPECT_EQ(words.size(), reasons);
  EXPECT_EQ(names.count("unknown") + words.count("no answer") + words.count("image dropped"), 0U);
}

TEST(FrameFaults, TheImageSizeThatTheFpgaModelHoldsIsNamed) {
  EXPECT_NE(explain(FrameStatus::CameraUnsupported).find("640 x 480"), std::string::npos);
}

TEST(FrameFaults, AGoodDriveIsNoConcern) {
  RunReport report;
  count(report, FrameStatus::Used, 70);
  count(report, FrameStatus::NoReference, 9);
  count(report, FrameStatus::NoMotion, 1);
  report.odometry["not_finite"] = 3;
  EXPECT_EQ(frameConcern(report, topics), "");
}

TEST(FrameFaults, DroppedFramesAreCountedByReason) {
  RunReport report;
  count(report, FrameStatus::Used, 70);
  count(report, FrameStatus::NoMotion, 7);
  count(report, FrameStatus::SizeMismatch, 2);
  count(report, GateDrop::OdometryGap, 1);
  EXPECT_EQ(frameConcern(report, topics),
            "3 of 80 frames dropped: gap in the odometry on /wheels (1), image is not of the "
            "calibrated size (2)");
}

TEST(FrameFaults, WithoutAUsedFrameEveryReasonIsNamed) {
  RunReport report;
  count(report, FrameStatus::NoMotion, 7);
  count(report, GateDrop::NoOdometry, 2);
  report.images += 1;
  report.unusable_images = 1;
  report.first_refusal = "encoding";
  report.odometry["not_finite"] = 3;
  EXPECT_EQ(frameConcern(report, topics),
            "none of 10 frames used: encoding (1), odometry on /wheels does not reach the images' "
            "stamps (2), the robot stands (7); refused messages on /wheels: not finite, without a "
            "stamp, or with an orientation that is no unit quaternion (3)");
}

}  // namespace
}  // namespace ipm_mapping
