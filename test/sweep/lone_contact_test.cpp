#include "ipm_mapping/sweep/lone_contact.hpp"

#include "sweep/plain_wall.hpp"

namespace ipm_mapping::sweep {
namespace {

/// Contacts at places of the table of scores, frame by frame.
class Lone : public PlainWall {
 protected:
  struct Place {
    int beam;
    float candidate;
  };
  void SetUp() override {
    PlainWall::SetUp();
    parameters.lone_frames = 2;
    parameters.lone_of = 4;
  }
  void configure() { lone.configure(sweep, parameters); }
  /// Beams that are doubtful of one frame's contacts.
  std::vector<int> doubtful(const std::vector<Place>& contacts, const SE2& T_floor_foot = {}) {
    std::vector<BeamChoice> choices(static_cast<std::size_t>(sweep.beams()));
    for (const Place& contact : contacts)
      choices[static_cast<std::size_t>(contact.beam)].candidate = contact.candidate;
    lone.mark(T_floor_foot, new_evidence, choices);
    std::vector<int> beams;
    for (std::size_t beam = 0; beam < choices.size(); ++beam)
      if (choices[beam].doubtful) beams.push_back(static_cast<int>(beam));
    return beams;
  }
  SelectionParameters parameters;
  LoneContact lone;
  bool new_evidence = true;
};

using Beams = std::vector<int>;

TEST_F(Lone, OneBeamIsDoubtfulTwoBesideEachOtherAreNot) {
  configure();
  EXPECT_EQ(doubtful({{10, 60.0F}}), Beams{10});
  EXPECT_EQ(doubtful({{20, 60.0F}, {21, 62.0F}}), Beams{});
  EXPECT_EQ(doubtful({{30, 60.0F}, {32, 57.0F}}), Beams{});
  EXPECT_EQ(doubtful({{5, 90.0F}, {8, 90.0F}}), (Beams{5, 8}));
}

TEST_F(Lone, BesideAnotherDistanceIsAlone) {
  configure();
  EXPECT_EQ(doubtful({{20, 60.0F}, {21, 66.0F}}), (Beams{20, 21}));
}

TEST_F(Lone, TheEndsOfTheViewHaveNeighboursOnOneSide) {
  configure();
  const int last = sweep.beams() - 1;
  EXPECT_EQ(doubtful({{0, 60.0F}, {last, 60.0F}}), (Beams{0, last}));
  EXPECT_EQ(doubtful({{0, 80.0F}, {1, 80.0F}, {last - 1, 90.0F}, {last, 90.0F}}), Beams{});
}

/// It stays where it is on the floor while the robot drives on: nearer, and on another beam.
TEST_F(Lone, ASecondSightFromAnotherPlaceIsBelieved) {
  configure();
  const ScoreGrid grid = sweep.scoreGrid();
  const Eigen::Vector2d p_floor = grid.point(12.0, 60.0);
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  const SE2 later{0.1, 0.02, 0.05};
  const Eigen::Vector2d p = later.inverse() * p_floor;
  const int beam = static_cast<int>(std::lround(grid.beam(p)));
  ASSERT_NE(beam, 12);
  EXPECT_EQ(doubtful({{beam, static_cast<float>(grid.candidate(p.norm()))}}, later), Beams{});
}

TEST_F(Lone, WhatStaysOnItsBeamWhileTheRobotDrivesIsNotTheSame) {
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 60.0F}}, {0.15, 0.0, 0.0}), Beams{12});
}

/// What is seen where another thing's outline ends moves with the view.
TEST_F(Lone, ThreePerCentFartherIsAnotherPlace) {
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 63.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 61.5F}}), Beams{});
}

TEST_F(Lone, SightsCountForTheLastFramesOnly) {
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  for (int k = 0; k < 2; ++k) doubtful({});
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{});
  for (int k = 0; k < 3; ++k) doubtful({});
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
}

TEST_F(Lone, MoreFramesCanBeAskedFor) {
  parameters.lone_frames = 3;
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{});
}

TEST_F(Lone, NoMoreSightsAreAskedForThanThereAreFrames) {
  parameters.lone_frames = 5;
  parameters.lone_of = 2;
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{});
  parameters.lone_of = 1;
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{});
}

/// A robot that stands sees the same again, out of the same views.
TEST_F(Lone, WhatIsNoNewEvidenceConfirmsNothing) {
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  new_evidence = false;
  for (int k = 0; k < 5; ++k) EXPECT_EQ(doubtful({{12, 60.0F}, {20, 60.0F}}), (Beams{12, 20}));
  new_evidence = true;
  EXPECT_EQ(doubtful({{12, 60.0F}, {20, 60.0F}}), Beams{20});
  new_evidence = false;
  EXPECT_EQ(doubtful({{12, 60.0F}, {20, 60.0F}}), Beams{20});
}

TEST_F(Lone, ResetForgetsAndOneFrameIsOff) {
  configure();
  doubtful({});
  doubtful({{12, 60.0F}});
  lone.reset();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{12});
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{});
  parameters.lone_frames = 1;
  configure();
  EXPECT_EQ(doubtful({{12, 60.0F}}), Beams{});
}

/// The table's places and the floor's points are each other's inverse.
TEST_F(Lone, ScoreGridGoesThereAndBack) {
  const ScoreGrid grid = sweep.scoreGrid();
  for (const double beam : {0.0, 7.5, 30.0}) {
    EXPECT_NEAR(grid.azimuth(beam), sweep.azimuth(0) + beam * (sweep.azimuth(1) - sweep.azimuth(0)),
                1e-12);
    for (const double candidate : {0.0, 33.25, 120.0}) {
      const Eigen::Vector2d p = grid.point(beam, candidate);
      EXPECT_NEAR(grid.beam(p), beam, 1e-9);
      EXPECT_NEAR(grid.candidate(p.norm()), candidate, 1e-9);
      EXPECT_NEAR(p.norm(), sweep.distance(candidate), 1e-9);
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::sweep
