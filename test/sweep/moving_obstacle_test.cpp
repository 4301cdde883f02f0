#include "ipm_mapping/sweep/moving_obstacle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <numeric>

#include "sweep/drive.hpp"

namespace ipm_mapping::sweep {
namespace {

TEST(FloorHistory, KnowsEveryPlaceOfTheLastFrames) {
  FloorHistory history;
  history.configure(0.05, 6.4);
  const Eigen::Vector2d always(1.01, -0.52), once(-2.0, 3.03), never(0.4, 0.4);
  for (int frame = 0; frame < 170; ++frame) {
    history.beginFrame(10.0 + 0.1 * frame, {0.02 * frame, 0.0});
    history.setFree(always);
    if (frame == 140) history.setFree(once);
  }
  EXPECT_EQ(history.framesAgo(10.0 + 0.1 * 169), 0);
  EXPECT_EQ(history.framesAgo(10.0 + 0.1 * 140), 29);
  EXPECT_EQ(history.framesAgo(10.0 + 0.1 * 42), 127);
  EXPECT_EQ(history.framesAgo(10.0 + 0.1 * 41), -1) << "forgotten";
  EXPECT_EQ(history.framesAgo(0.0), -1) << "never seen";
  EXPECT_DOUBLE_EQ(history.foot(29).x(), 2.8);
  for (int ago = 0; ago < FloorHistory::most_frames; ++ago) {
    EXPECT_TRUE(history.wasFree(always, ago)) << ago;
    EXPECT_EQ(history.wasFree(once, ago), ago == 29) << ago;
    EXPECT_FALSE(history.wasFree(never, ago)) << ago;
  }
  EXPECT_TRUE(history.wasFree(always + Eigen::Vector2d(0.03, 0.01), 5)) << "the same cell";
  EXPECT_FALSE(history.wasFree(always + Eigen::Vector2d(0.05, 0.0), 5)) << "the next one";
}

TEST(FloorHistory, BeginsAnew) {
  FloorHistory history;
  history.configure(0.05, 6.4);
  const Eigen::Vector2d p(1.0, 1.0);
  for (int frame = 0; frame < 5; ++frame) {
    history.beginFrame(frame, p);
    history.setFree(p);
  }
  history.clear();
  EXPECT_EQ(history.framesAgo(4.0), -1);
  history.beginFrame(5.0, p);
  EXPECT_FALSE(history.wasFree(p, 0));
}

TEST(FloorHistory, APlaceThatWasNotSeenForLongIsForgotten) {
  FloorHistory history;
  history.configure(0.05, 6.4);
  const Eigen::Vector2d p(0.5, 0.5);
  for (const double stamp : {-1.0, 0.0}) {
    history.beginFrame(stamp, p);
    history.setFree(p);
  }
  for (int frame = 1; frame <= 200; ++frame) history.beginFrame(frame, p);
  for (int ago = 0; ago < FloorHistory::most_frames; ++ago) EXPECT_FALSE(history.wasFree(p, ago));
  history.setFree(p);
  EXPECT_TRUE(history.wasFree(p, 0));
  EXPECT_FALSE(history.wasFree(p, 1));
}

/// Two references of which each, when it was the current frame, saw floor up to some range, and
/// what they make of the present frame.
class Come : public ::testing::Test {
 protected:
  using Range = std::function<double(int beam)>;

  void SetUp() override {
    const CameraModel camera = test::smallCamera();
    T_base_camera = test::smallCameraPose();
    const SweepParameters p = test::smallParameters();
    const PolarGrid grid = makePolarGrid(camera, T_base_camera, p.grid, 2.0);
    CylindricalRectification rectification;
    rectification.configure(camera, T_base_camera, grid);
    NoiseModel noise;
    noise.configure(grid, rectification.ranges(), p.noise);
    sweep.configure(grid, rectification.ranges(), noise.sweepRows(), p.grid.max_support,
                    p.evidence);
    moving.configure(sweep, 2.0, p.evidence, p.selection, p.moving);
    for (std::size_t q = 0; q < 2; ++q) {
      cost[q].resize(grid.sweepRows(), sweep.beams(), 0);
      references[q].floor_cost = cost[q].view();
      references[q].stamp = static_cast<double>(q);
    }
  }
  /// The frame of a reference, from where it saw floor up to a range in every beam.
  void sawFree(double stamp, const SE2& T_floor_foot, const Range& range) {
    Obstacles obstacles;
    obstacles.view.T_base_camera = T_base_camera;
    obstacles.view.stamp = stamp;
    obstacles.max_range = looked_to;
    for (int beam = 0; beam < sweep.beams(); ++beam) {
      Bearing bearing;
      bearing.angle = static_cast<float>(sweep.azimuth(beam));
      bearing.state = BearingState::Free;
      bearing.near = 0.3F;
      bearing.range = static_cast<float>(range(beam));
      obstacles.bearings.push_back(bearing);
    }
    moving.remember(T_floor_foot, obstacles);
  }
  /// From a candidate upwards a reference finds no floor in beams first ... end - 1.
  void noFloor(std::size_t q, int first, int end, int candidate, double sigma2 = 9.0) {
    for (int beam = first; beam < end; ++beam)
      for (int row = 0; row <= static_cast<int>(sweep.sweepRow(candidate)); ++row)
        cost[q].at(row, beam) = static_cast<std::uint16_t>(sigma2 * kernels::cost_unit);
  }
  /// Beams with a moving contact at the second sight.
  std::vector<int> found(const SE2& T_floor_foot, const std::vector<int>& taken = {}) {
    std::vector<int> beams;
    for (int sight = 0; sight < 2; ++sight) {
      choices.assign(static_cast<std::size_t>(sweep.beams()), {});
      for (const int beam : taken)
        choices[static_cast<std::size_t>(beam)].candidate = taken_at,
        choices[static_cast<std::size_t>(beam)].doubtful = taken_doubtful;
      moving.complete({CurrentView{}, references.data(), 2, sweep}, T_floor_foot,
                      clock += between_sights, choices);
    }
    for (std::size_t beam = 0; beam < choices.size(); ++beam)
      if (choices[beam].moving) beams.push_back(static_cast<int>(beam));
    return beams;
  }
  [[nodiscard]] int candidateAt(double distance) const {
    return static_cast<int>(std::lround(sweep.scoreGrid().candidate(distance)));
  }
  static double everywhere(int) { return 2.0; }
  static std::vector<int> from(int first, int end) {
    std::vector<int> beams(static_cast<std::size_t>(end - first));
    std::iota(beams.begin(), beams.end(), first);
    return beams;
  }

  CameraPose T_base_camera;
  VerticalSweep sweep;
  MovingObstacle moving;
  float taken_at = 30.0F;  // candidate
  bool taken_doubtful = false;
  double looked_to = 10.0;  // metres from base
  double clock = 2.0, between_sights = 0.1;
  std::array<Image<std::uint16_t>, 2> cost;
  std::array<SweepReference, 2> references;
  std::vector<BeamChoice> choices;
};

TEST_F(Come, OntoFloorThatBothReferencesSawFree) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
  EXPECT_EQ(found({0.3, 0.0, 0.0}), from(12, 20));
  EXPECT_NEAR(choices[15].candidate, candidateAt(1.2), 1.01);
  EXPECT_GT(choices[15].score, 20.0F);
}

TEST_F(Come, OneReferenceThatSawItFreeIsEnough) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, [](int) { return 0.8; });
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
  EXPECT_EQ(found({0.3, 0.0, 0.0}), from(12, 20));
}

/// Somebody may stand where free floor ends, unless it ends because nobody looks farther.
TEST_F(Come, TheEndOfFreeFloorIsNotSurelyFree) {
  const int middle = sweep.beams() / 2;
  const auto comes_before_the_end = [&](double metres) {
    moving.reset();
    sawFree(1.0, {0.15, 0.0, 0.0}, [](int) { return 1.5; });
    for (Image<std::uint16_t>& image : cost)
      std::fill(image.row(0), image.row(image.height()), std::uint16_t{0});
    for (const std::size_t q : {0U, 1U})
      noFloor(q, middle - 2, middle + 3, candidateAt(1.35 - 0.03 - metres));
    return !found({0.3, 0.0, 0.0}).empty();
  };
  EXPECT_TRUE(comes_before_the_end(0.15));
  EXPECT_FALSE(comes_before_the_end(0.075));
  looked_to = 1.5 + T_base_camera.translation().x();
  EXPECT_TRUE(comes_before_the_end(0.075));
  EXPECT_FALSE(comes_before_the_end(0.025));
}

TEST_F(Come, NothingWhereNeitherSawFloor) {
  sawFree(0.0, {0.0, 0.0, 0.0}, [](int) { return 1.1; });
  sawFree(1.0, {0.15, 0.0, 0.0}, [](int) { return 0.8; });
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty());
}

TEST_F(Come, NothingWhereOneReferenceStillFindsFloor) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  noFloor(1, 12, 20, candidateAt(1.2));  // what has left the place is in this reference only
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty());
}

TEST_F(Come, NothingWhereTheReferencesAreNotKnown) {
  sawFree(7.0, {0.0, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty());
}

/// The robot has been carried sideways; what it sees now it saw at the same place of the view. At
/// the edges a cell of the history belongs to both.
TEST_F(Come, NotWhatGoesAlong) {
  const auto beside = [](int beam) { return beam < 8 || beam >= 26 ? 2.0 : 0.8; };
  for (const std::size_t q : {0U, 1U}) noFloor(q, 8, 26, candidateAt(1.2));
  sawFree(0.0, {0.0, 0.0, 0.0}, beside);
  sawFree(1.0, {0.0, 0.25, 0.0}, beside);
  for (const int beam : found({0.0, 0.5, 0.0})) EXPECT_TRUE(beam < 10 || beam >= 24) << beam;
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.0, 0.25, 0.0}, everywhere);
  EXPECT_EQ(found({0.0, 0.5, 0.0}), from(8, 26)) << "the view was free there";
}

TEST_F(Come, BeamsInBetweenThatLookLikeFloorAreFilled) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) {
    noFloor(q, 10, 12, candidateAt(1.2));
    noFloor(q, 17, 19, candidateAt(1.2) + 4);
  }
  EXPECT_EQ(found({0.3, 0.0, 0.0}), from(10, 19));
  EXPECT_GT(choices[14].candidate, choices[10].candidate);
  EXPECT_LT(choices[14].candidate, choices[18].candidate);
}

TEST_F(Come, InFrontOfWhatStandsBehindItWhenItIsWideEnough) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) {
    noFloor(q, 24, 27, candidateAt(1.2));  // three beams: 8 cm
    noFloor(q, 35, 43, candidateAt(1.2));
  }
  std::vector<int> both = from(24, 27);
  for (const int beam : from(35, 43)) both.push_back(beam);
  EXPECT_EQ(found({0.3, 0.0, 0.0}), both) << "nothing behind them";
  const std::vector<int> wall = from(0, sweep.beams());  // at candidate 30
  EXPECT_EQ(found({0.3, 0.0, 0.0}, wall), from(35, 43));
  EXPECT_NEAR(choices[39].candidate, candidateAt(1.2), 1.01);
  EXPECT_EQ(choices[25].candidate, 30.0F) << "not wide enough to hide a contact";
  taken_at = static_cast<float>(candidateAt(1.2)) - 5.0F;
  EXPECT_TRUE(found({0.3, 0.0, 0.0}, wall).empty()) << "that is the contact itself";
  taken_at = static_cast<float>(candidateAt(0.8));
  EXPECT_TRUE(found({0.3, 0.0, 0.0}, wall).empty()) << "nearer ones stay";
}

TEST_F(Come, WhatIsNearerInBetweenStays) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) {
    noFloor(q, 10, 12, candidateAt(1.2));
    noFloor(q, 17, 19, candidateAt(1.2));
  }
  taken_at = static_cast<float>(candidateAt(0.8));
  EXPECT_EQ(found({0.3, 0.0, 0.0}, {14}), (std::vector<int>{10, 11, 12, 13, 15, 16, 17, 18}));
  EXPECT_EQ(choices[14].candidate, taken_at);
}

TEST_F(Come, WhatLiesBehindOneAnotherIsNotOneThing) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) {
    noFloor(q, 12, 14, candidateAt(0.7));
    noFloor(q, 14, 16, candidateAt(0.85));
  }
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty()) << "each is three centimetres wide";
}

TEST_F(Come, ADoubtfulContactGivesWay) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
  taken_at = static_cast<float>(candidateAt(1.2));
  taken_doubtful = true;
  EXPECT_EQ(found({0.3, 0.0, 0.0}, from(12, 20)), from(12, 20));
  EXPECT_FALSE(choices[15].doubtful);
}

TEST_F(Come, WhatLiesElsewhereBetweenTwoBeamsDoesNotBelongToThem) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) {
    for (const int beam : {12, 13, 18, 19}) noFloor(q, beam, beam + 1, candidateAt(0.9));
    noFloor(q, 16, 17, candidateAt(1.5));
  }
  EXPECT_EQ(found({0.3, 0.0, 0.0}), from(12, 20));
  for (int beam = 12; beam < 20; ++beam)
    EXPECT_NEAR(choices[static_cast<std::size_t>(beam)].candidate, candidateAt(0.9), 1.01) << beam;
}

TEST_F(Come, ASightLongAgoIsNotTheFirstOfTwo) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
  between_sights = 0.6;
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty());
  between_sights = 0.4;
  EXPECT_EQ(found({0.3, 0.0, 0.0}), from(12, 20));
}

TEST_F(Come, WhicheverWayTheRobotLooks) {
  for (const double heading : {M_PI_2, M_PI, -2.0}) {
    const SE2 turned{0.7, -0.4, heading};
    moving.reset();
    sawFree(0.0, turned, everywhere);
    sawFree(1.0, turned * SE2{0.15, 0.0, 0.0}, everywhere);
    for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2));
    EXPECT_EQ(found(turned * SE2{0.3, 0.0, 0.0}), from(12, 20)) << heading;
    moving.reset();
    sawFree(0.0, turned, [](int) { return 1.1; });
    sawFree(1.0, turned * SE2{0.15, 0.0, 0.0}, [](int) { return 1.0; });
    EXPECT_TRUE(found(turned * SE2{0.3, 0.0, 0.0}).empty()) << heading;
  }
}

TEST_F(Come, AChangeThatIsTooSmallIsNone) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2), 2.9);
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty());
}

TEST_F(Come, WhatWasNotComparedSaysNothing) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) noFloor(q, 12, 20, candidateAt(1.2), 31.99);
  ASSERT_FALSE(found({0.3, 0.0, 0.0}).empty());
  for (Image<std::uint16_t>& image : cost)
    std::replace_if(
        image.row(0), image.row(image.height()), [](std::uint16_t c) { return c > 0; },
        kernels::no_cost);
  EXPECT_TRUE(found({0.3, 0.0, 0.0}).empty());
}

/// The edge of a shadow in front of somebody is not where he stands.
TEST_F(Come, ABandOnTheFloorIsPassedOver) {
  sawFree(0.0, {0.0, 0.0, 0.0}, everywhere);
  sawFree(1.0, {0.15, 0.0, 0.0}, everywhere);
  for (const std::size_t q : {0U, 1U}) {
    noFloor(q, 12, 20, candidateAt(1.3));
    for (int beam = 12; beam < 20; ++beam)
      for (int row = 0; row < 5; ++row)
        cost[q].at(static_cast<int>(sweep.sweepRow(candidateAt(0.7))) + row, beam) =
            9 * kernels::cost_unit;
  }
  EXPECT_EQ(found({0.3, 0.0, 0.0}), from(12, 20));
  EXPECT_NEAR(choices[15].candidate, candidateAt(1.3), 1.01);
}

/// A robot that drives over open floor; what `boxes` says stands there in each frame.
class MovingObstacles : public ::testing::Test {
 protected:
  void start(const SweepParameters& parameters = test::smallParameters()) {
    drive = std::make_unique<test::Drive>(parameters);
  }
  /// Drives on in steps of `way`; `place(k, x)` sets the boxes of frame k with the robot at x.
  template <class Place>
  void go(int frames, const Place& place) {
    for (int k = 0; k < frames; ++k, x += way) {
      drive->scene.boxes.clear();
      place(k, x);
      ASSERT_NE(drive->at({x, 0.0, 0.0}), FrameStatus::NoMotion);
      counts.push_back(moving());
      for (const Contact& c : drive->obstacles.contacts)
        if (c.moving)
          farthest_off = std::max(
              farthest_off, drive->scene.boxes.empty()
                                ? 1.0
                                : drive->scene.distanceToOutline(
                                      drive->last * Eigen::Vector2d(c.p_base.cast<double>())));
    }
  }
  [[nodiscard]] int moving() const {
    const auto& contacts = drive->obstacles.contacts;
    return static_cast<int>(
        std::count_if(contacts.begin(), contacts.end(), [](const Contact& c) { return c.moving; }));
  }
  [[nodiscard]] int total() const { return std::accumulate(counts.begin(), counts.end(), 0); }
  void openFloor(int frames) {
    go(frames, [](int, double) {});
    ASSERT_EQ(total(), 0);
    counts.clear();
  }
  /// Somebody who comes from the right, 10 cm a frame.
  auto crossing() {
    return [this](int k, double) {
      const double y = -1.0 + 0.1 * k;
      drive->scene.boxes = {{1.6, 1.75, y, y + 0.2, 0.9}};
    };
  }

  std::unique_ptr<test::Drive> drive;
  double x = 0.0, way = 0.025, farthest_off = 0.0;
  std::vector<int> counts;  // moving contacts of every frame
};

TEST_F(MovingObstacles, SomebodyWhoCrossesIsSeenWhereHeIs) {
  start();
  openFloor(20);
  go(16, crossing());
  const auto seen = std::count_if(counts.begin(), counts.end(), [](int n) { return n >= 2; });
  EXPECT_GE(seen, 8);
  EXPECT_LT(farthest_off, 0.06);
  for (const Contact& c : drive->obstacles.contacts) {
    const Bearing& b = drive->obstacles.bearings[static_cast<std::size_t>(c.bearing)];
    EXPECT_EQ(b.state, BearingState::Occupied);
  }
}

TEST_F(MovingObstacles, AreLookedForOnlyWhereThatIsAskedFor) {
  SweepParameters parameters = test::smallParameters();
  parameters.moving.moving_score = 0.0;
  start(parameters);
  openFloor(20);
  go(16, crossing());
  EXPECT_EQ(total(), 0);
}

TEST_F(MovingObstacles, NeedTwoSights) {
  start();
  openFloor(20);
  go(1, [this](int, double) { drive->scene.boxes = {{1.6, 1.75, -0.1, 0.15, 0.9}}; });
  EXPECT_EQ(counts.back(), 0);
  go(1, [this](int, double) { drive->scene.boxes = {{1.6, 1.75, 0.0, 0.25, 0.9}}; });
  EXPECT_GE(counts.back(), 2);
  // two of which the second is somewhere else are two first sights
  go(8, [](int, double) {});
  go(1, [this](int, double) { drive->scene.boxes = {{1.7, 1.85, -0.5, -0.3, 0.9}}; });
  EXPECT_EQ(counts.back(), 0);
  go(1, [this](int, double) { drive->scene.boxes = {{1.7, 1.85, 0.3, 0.5, 0.9}}; });
  EXPECT_EQ(counts.back(), 0);
}

TEST_F(MovingObstacles, WhatStandsDoesNotMove) {
  start();
  go(36, [this](int, double) { drive->scene.boxes = {{1.6, 1.75, -0.3, 0.3, 0.4}}; });
  EXPECT_EQ(total(), 0);
  EXPECT_GE(drive->obstacles.contacts.size(), 4U) << "and is found as before";
}

TEST_F(MovingObstacles, WhereSomethingHasLeftThereIsNothing) {
  start();
  go(20, [this](int, double) { drive->scene.boxes = {{1.6, 1.75, -0.3, 0.3, 0.4}}; });
  ASSERT_EQ(total(), 0);
  go(16, [](int, double) {});
  EXPECT_EQ(total(), 0);
}

TEST_F(MovingObstacles, AreAsWideAndAsHighAsIsAskedFor) {
  const auto contacts = [this](double width, double height, double box_height) {
    SweepParameters parameters = test::smallParameters();
    parameters.moving.moving_width = width;
    parameters.moving.moving_height = height;
    start(parameters);
    x = 0.0;
    openFloor(20);
    go(12, [&](int k, double) {
      const double y = -0.8 + 0.1 * k;
      drive->scene.boxes = {{1.6, 1.62, y, y + 0.2, box_height}};
    });
    const int found = total();
    counts.clear();
    return found;
  };
  EXPECT_GE(contacts(0.1, 0.2, 0.5), 10);
  EXPECT_EQ(contacts(0.3, 0.2, 0.5), 0) << "it is 20 cm wide";
  EXPECT_GE(contacts(0.1, 0.2, 0.15), 10);
  EXPECT_EQ(contacts(0.1, 0.5, 0.15), 0) << "it is a third of the camera's height high";
}

}  // namespace
}  // namespace ipm_mapping::sweep
