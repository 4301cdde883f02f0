#include "ipm_mapping/geometry/reference_selector.hpp"

#include <gtest/gtest.h>

namespace ipm_mapping {
namespace {

using Verdict = ReferenceVerdict;

class ReferenceSelectorTest : public ::testing::Test {
 protected:
  /// Remembers a frame whose pixels all have the value `gray`.
  static void remember(ReferenceSelector& selector, double stamp, const SE2& pose,
                       std::uint8_t gray = 0) {
    Image<std::uint8_t> image(8, 4, gray);
    selector.remember(stamp, pose, image.view());
  }
  static ReferenceSelector driven(const ReferenceParameters& parameters, int frames) {
    ReferenceSelector selector(parameters);
    for (int i = 0; i < frames; ++i)
      remember(selector, 0.1 * i, {0.03 * i, 0.0, 0.0}, static_cast<std::uint8_t>(i));
    return selector;
  }
};

TEST_F(ReferenceSelectorTest, TakesTheNewestFrameFarEnoughBack) {
  ReferenceParameters parameters;
  parameters.min_baseline = 0.10;
  const ReferenceSelector selector = driven(parameters, 10);
  const auto choice = selector.choose(1.0, {0.30, 0.0, 0.05});
  ASSERT_EQ(choice.verdict, Verdict::Chosen);
  EXPECT_EQ(choice.reference->image.at(3, 2), 6) << "0.12 m back; 0.09 m are too few";
  EXPECT_NEAR(choice.motion.x, 0.12, 1e-12);
  EXPECT_NEAR(choice.motion.theta, 0.05, 1e-12);
}

TEST_F(ReferenceSelectorTest, MotionIsThePoseOfTheCurrentBaseInTheReferenceBase) {
  ReferenceSelector selector;
  const SE2 before{1.0, 2.0, 1.2}, step{0.15, 0.02, 0.1};
  remember(selector, 0.0, before);
  const auto choice = selector.choose(0.1, before * step);
  ASSERT_EQ(choice.verdict, Verdict::Chosen);
  EXPECT_NEAR(choice.motion.x, step.x, 1e-12);
  EXPECT_NEAR(choice.motion.y, step.y, 1e-12);
  EXPECT_NEAR(choice.motion.theta, step.theta, 1e-12);
}

TEST_F(ReferenceSelectorTest, SaysWhyThereIsNone) {
  ReferenceParameters parameters;
  EXPECT_EQ(ReferenceSelector(parameters).choose(0.0, {}).verdict, Verdict::NoReference);
  const ReferenceSelector selector = driven(parameters, 3);
  EXPECT_EQ(selector.choose(0.3, {0.09, 0.0, 0.0}).verdict, Verdict::NoReference)
      << "not yet far enough from the first";
  EXPECT_EQ(selector.choose(0.3, {0.0605, 0.0, 0.0}).verdict, Verdict::NoMotion);
  EXPECT_EQ(selector.choose(0.3, {0.0605, 0.0, 0.2}).verdict, Verdict::TooMuchRotation)
      << "turning on the spot";
  EXPECT_EQ(selector.choose(0.3, {0.2, 0.0, 0.5}).verdict, Verdict::TooMuchRotation);
  EXPECT_EQ(selector.choose(20.0, {0.2, 0.0, 0.0}).verdict, Verdict::NoReference) << "too old";
}

TEST_F(ReferenceSelectorTest, PreviousFrameWhateverTheBaseline) {
  ReferenceParameters parameters;
  parameters.previous_frame = true;
  const ReferenceSelector selector = driven(parameters, 10);
  const auto choice = selector.choose(1.0, {0.28, 0.0, 1.0});
  ASSERT_EQ(choice.verdict, Verdict::Chosen);
  EXPECT_EQ(choice.reference->image.at(0, 0), 9);
  EXPECT_EQ(selector.choose(1.0, {0.2705, 0.0, 0.0}).verdict, Verdict::NoMotion);
}

TEST_F(ReferenceSelectorTest, AStandingRobotDoesNotPushItsHistoryOut) {
  ReferenceParameters parameters;
  parameters.history = 8;
  parameters.max_age = 60.0;
  ReferenceSelector selector = driven(parameters, 8);
  for (int i = 0; i < 100; ++i) remember(selector, 1.0 + 0.1 * i, {0.2105, 0.0, 0.0}, 200);
  EXPECT_EQ(selector.size(), 8);
  const auto choice = selector.choose(12.0, {0.24, 0.0, 0.0});
  ASSERT_EQ(choice.verdict, Verdict::Chosen);
  EXPECT_EQ(choice.reference->image.at(0, 0), 4);
}

TEST_F(ReferenceSelectorTest, TheRingKeepsTheNewestFramesWhenItWraps) {
  ReferenceParameters parameters;
  parameters.history = 4;
  parameters.min_baseline = 0.119;
  const ReferenceSelector selector = driven(parameters, 23);
  EXPECT_EQ(selector.size(), 4);
  const auto choice = selector.choose(2.3, {0.03 * 23, 0.0, 0.0});
  ASSERT_EQ(choice.verdict, Verdict::Chosen);
  EXPECT_EQ(choice.reference->image.at(7, 3), 19) << "the oldest of the four";
  EXPECT_EQ(selector.choose(2.3, {0.03 * 22 + 0.02, 0.0, 0.0}).verdict, Verdict::NoReference);
}

TEST_F(ReferenceSelectorTest, ClearForgets) {
  ReferenceSelector selector = driven({}, 10);
  selector.clear();
  EXPECT_EQ(selector.size(), 0);
  EXPECT_EQ(selector.choose(1.0, {0.5, 0.0, 0.0}).verdict, Verdict::NoReference);
}

TEST_F(ReferenceSelectorTest, KeepsItsOwnCopyOfPaddedRows) {
  ReferenceSelector selector;
  std::vector<std::uint8_t> pixels(10 * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i);
  selector.remember(0.0, {}, {pixels.data(), 6, 3, 10});
  std::fill(pixels.begin(), pixels.end(), std::uint8_t{255});
  const auto choice = selector.choose(0.1, {0.2, 0.0, 0.0});
  ASSERT_EQ(choice.verdict, Verdict::Chosen);
  for (int v = 0; v < 3; ++v)
    for (int u = 0; u < 6; ++u) EXPECT_EQ(choice.reference->image.at(u, v), 10 * v + u);
}

}  // namespace
}  // namespace ipm_mapping
