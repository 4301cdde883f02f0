#include "ipm_mapping/detectors/localization.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

constexpr int W = 641, H = 480;

/// A level camera that stands: lines stand upright, the floor begins below row 240.
GroundView levelView() {
  GroundView view;
  view.camera = CameraModel({W, H, 400, 400, 320, 239.5}, {});
  view.T_base_camera = cameraPose(0.1, 0.0, 0.4, 0.0);
  return view;
}

void wedge(Picture& mask, int u, int tip, int rows) {
  for (int k = 0; k < rows; ++k)
    for (int i = u - k; i <= u + k; ++i)
      if (mask.view().contains(i, tip - k)) mask(i, tip - k) = mask::obstacle;
}

struct Answer {
  FrameStatus status;
  Obstacles obstacles;
};
Answer locate(const Picture& mask, LocalizationParameters parameters = {},
              const GroundView& view = levelView()) {
  Answer answer;
  Localization localization(parameters);
  answer.status = localization.process(view, mask.view(), answer.obstacles);
  return answer;
}

/// The bearing whose line stands on column 320 + 8 (i - 40) + 4.
constexpr int line = 40, column = 324;

TEST(Localization, ContactProjectsToTheFloorPointOfItsPixel) {
  Picture mask(W, H);
  wedge(mask, column, 400, 30);
  const Answer answer = locate(mask);
  ASSERT_EQ(answer.status, FrameStatus::Used);
  const Bearing& bearing = answer.obstacles.bearings[line];
  ASSERT_EQ(bearing.state, BearingState::Occupied);
  // A level camera: distance = height * f / rows below the horizon.
  const double x = 0.4 * 400 / (400 - 239.5), y = -x * (column - 320) / 400;
  EXPECT_NEAR(bearing.range, std::hypot(x, y), 1e-6);
  EXPECT_NEAR(bearing.angle, std::atan2(y, x), 1e-6);
  const auto contact =
      std::find_if(answer.obstacles.contacts.begin(), answer.obstacles.contacts.end(),
                   [](const Contact& c) { return c.bearing == line; });
  ASSERT_NE(contact, answer.obstacles.contacts.end());
  EXPECT_NEAR(contact->p_base.x(), 0.1 + x, 1e-6);
  EXPECT_NEAR(contact->p_base.y(), y, 1e-6);
}

TEST(Localization, FreeBearingReachesFromTheLowestSeenRowToTheRange) {
  Picture mask(W, H);
  for (int u = 0; u < W; ++u) mask(u, H - 1) = mask(u, H - 2) = mask::unseen;
  LocalizationParameters parameters;
  parameters.max_range = 2.0;
  const Answer answer = locate(mask, parameters);
  const Bearing& bearing = answer.obstacles.bearings[line];
  EXPECT_EQ(bearing.state, BearingState::Free);
  const double slant = std::hypot(1.0, (column - 320) / 400.0);
  EXPECT_NEAR(bearing.near, slant * 0.4 * 400 / (H - 3 - 239.5), 1e-5);
  // The highest row whose floor is within 2 m of the base origin.
  double far = 0.0;
  for (int v = H - 3; v > 240; --v) {
    const double x = 0.4 * 400 / (v - 239.5);
    if (std::hypot(0.1 + x, x * (column - 320) / 400.0) > 2.0) break;
    far = slant * x;
  }
  EXPECT_NEAR(bearing.range, far, 1e-5);
  EXPECT_TRUE(answer.obstacles.contacts.empty());
}

TEST(Localization, FreeFloorEndsWhereItWasNotSeen) {
  Picture mask(W, H);
  for (int v = 380; v < 383; ++v)
    for (int u = 0; u < W; ++u) mask(u, v) = mask::unseen;
  const Answer answer = locate(mask);
  const Bearing& bearing = answer.obstacles.bearings[line];
  EXPECT_EQ(bearing.state, BearingState::Free);
  EXPECT_NEAR(bearing.range, std::hypot(1.0, 0.01) * 0.4 * 400 / (383 - 239.5), 1e-5);
}

TEST(Localization, BearingIsUnknownWhereLittleFloorWasSeen) {
  for (const double share : {0.4, 0.6}) {
    Picture mask(W, H);
    int rows = 0;
    for (int v = H - 1; v > 240; --v) {
      const double x = 0.4 * 400 / (v - 239.5);
      rows += std::hypot(0.1 + x, x * (column - 320) / 400.0) <= 2.0;
    }
    for (int v = H - 1; v > H - 1 - static_cast<int>(rows * (1.0 - share)); --v)
      for (int u = 0; u < W; ++u) mask(u, v) = mask::unseen;
    LocalizationParameters parameters;
    parameters.max_range = 2.0;
    EXPECT_EQ(locate(mask, parameters).obstacles.bearings[line].state,
              share < 0.5 ? BearingState::Unknown : BearingState::Free);
  }
}

TEST(Localization, BlobWithoutAFootBlocksItsBearing) {
  Picture mask(W, H);
  wedge(mask, column, 520, 100);
  const Answer answer = locate(mask);
  EXPECT_EQ(answer.obstacles.bearings[line].state, BearingState::Blocked);
  EXPECT_NEAR(answer.obstacles.bearings[line].range, 0.4 * 400 / (H - 1 - 239.5), 1e-4);
  for (const Contact& c : answer.obstacles.contacts) EXPECT_NE(c.bearing, line);
}

TEST(Localization, ContactBehindABlobIsACandidateOnly) {
  Picture mask(W, H);
  wedge(mask, column, 350, 40);
  wedge(mask, column, 500, 60);
  const Answer answer = locate(mask);
  EXPECT_EQ(answer.obstacles.bearings[line].state, BearingState::Blocked);
  EXPECT_FALSE(answer.obstacles.candidates.empty());
  for (const Contact& c : answer.obstacles.contacts) EXPECT_NE(c.bearing, line);
}

TEST(Localization, ObstacleBeyondTheRangeLeavesTheBearingFree) {
  Picture mask(W, H);
  wedge(mask, column, 290, 30);  // 3.2 m
  LocalizationParameters parameters;
  parameters.max_range = 2.0;
  const Answer answer = locate(mask, parameters);
  EXPECT_EQ(answer.obstacles.bearings[line].state, BearingState::Free);
  EXPECT_TRUE(answer.obstacles.candidates.empty());
}

TEST(Localization, PeaksGiveOneContactAnObstacle) {
  Picture mask(W, H);
  wedge(mask, 164, 400, 40);
  wedge(mask, 484, 420, 40);
  LocalizationParameters parameters;
  parameters.selection = Selection::Peaks;
  const Answer answer = locate(mask, parameters);
  ASSERT_EQ(answer.obstacles.contacts.size(), 2U);
  EXPECT_NEAR(answer.obstacles.contacts[0].u, 164, 4);
  EXPECT_NEAR(answer.obstacles.contacts[1].u, 484, 4);
  EXPECT_GT(answer.obstacles.candidates.size(), 2U);
}

TEST(Localization, RangeGrowsWithTheDistanceOfTheFirstFloor) {
  const GroundView view = levelView();
  EXPECT_EQ(effectiveMaxRange(1.2, view.camera, view.T_base_camera), 1.2);
  EXPECT_EQ(effectiveMaxRange(0.0, view.camera, cameraPose(0, 0, 0.3, 0.3)), 2.0);
  // 1.6 m up and level: the floor comes into view at 1.6 * 400 / 239.5.
  EXPECT_NEAR(effectiveMaxRange(0.0, view.camera, cameraPose(0, 0, 1.6, 0)), 3 * 1.6 * 400 / 239.5,
              1e-9);
  EXPECT_EQ(effectiveMaxRange(0.0, view.camera, cameraPose(0, 0, 1.6, -0.9)), 2.0);
}

}  // namespace
}  // namespace ipm_mapping::test
