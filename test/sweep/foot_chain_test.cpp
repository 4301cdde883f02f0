#include "ipm_mapping/sweep/foot_chain.hpp"

#include <gtest/gtest.h>

#include "sweep/plain_wall.hpp"

namespace ipm_mapping::sweep {
namespace {

/// A plain wall that single beams have contacts at.
class Chain : public WallWithContacts {
 protected:
  void SetUp() override {
    WallWithContacts::SetUp();
    parameters.chain_gap = 20;
    parameters.chain_beams = 0;
  }
  void complete() { WallWithContacts::complete<FootChain>(); }
  /// Something in the face, so many rows above its foot, that looks like no floor.
  void featureAbove(int rows, int first, int last, double sigmas) {
    for (int beam = first; beam <= last; ++beam) {
      const int row = static_cast<int>(std::lround(sweep.sweepRow(foot(beam)))) - rows;
      for (int j = row - 2; j <= row + 2; ++j)
        cost.at(j, beam) = static_cast<std::uint16_t>(sigmas * kernels::cost_unit);
    }
  }
};

TEST_F(Chain, TheFootGoesOnBetweenTwoContacts) {
  contact(10, 0.0, 30);
  contact(24, 0.0, 26);
  complete();
  for (int beam = 11; beam < 24; ++beam) {
    ASSERT_TRUE(at(beam).any()) << beam;
    EXPECT_NEAR(at(beam).candidate, foot(beam), 1.0) << beam;
    EXPECT_TRUE(at(beam).by_edge);
    EXPECT_FLOAT_EQ(at(beam).score, 15.0F);
    EXPECT_NEAR(sweep.sweepRow(at(beam).candidate) - at(beam).top, 26.0, 1.0) << "the lower one's";
  }
  EXPECT_FLOAT_EQ(at(10).score, 30.0F) << "a contact that was there stays as it is";
  EXPECT_EQ(found(0, sweep.beams() - 1), 15);
}

TEST_F(Chain, ContactsFartherApartSayNothing) {
  parameters.chain_gap = 13;
  contact(10);
  contact(24);
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 2);
  parameters.chain_gap = 14;
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 15);
}

TEST_F(Chain, OnlyTheSameEdgeGoesOn) {
  struct Between {
    const char* what;
    int grey;
  };
  for (const Between& between :
       {Between{"floor", floor_grey}, Between{"an edge of other polarity", 140},
        Between{"a fainter edge", 88}}) {
    SCOPED_TRACE(between.what);
    paint(0, sweep.beams() - 1, wall_grey);
    paint(15, 18, between.grey);
    contact(10);
    contact(24);
    complete();
    EXPECT_EQ(found(11, 23), 0);
    choices.assign(choices.size(), BeamChoice{});
  }
}

TEST_F(Chain, AContactBesideTheEdgeIsNotItsEnd) {
  contact(10);
  contact(24, 3.0 * parameters.chain_step);
  complete();
  EXPECT_EQ(found(11, 23), 0);
}

/// A second face, alike and nearer, is not the same edge.
TEST_F(Chain, AStepInTheEdgeEndsIt) {
  const double nearer = 0.85;
  const auto row = [&](int line) { return grid.row(nearer / std::cos(grid.azimuth(line))); };
  for (int line = sweep.firstLine(17); line < grid.lines; ++line)
    for (int j = 0; j < grid.sweepRows(); ++j)
      grey.at(j, line) = static_cast<std::int16_t>(
          kernels::grey_unit *
          (PolarGrid::rows_per_sweep_row * j < row(line) ? wall_grey : floor_grey));
  contact(10);
  const double foot_of_it =
      row(sweep.firstLine(24) + kernels::beam_lines / 2) / PolarGrid::rows_per_sweep_row;
  contact(24, foot_of_it - sweep.sweepRow(foot(24)));
  complete();
  EXPECT_EQ(found(11, 23), 0);
  parameters.chain_step = 100.0;
  complete();
  EXPECT_EQ(found(11, 23), 13) << "nothing else parts them";
}

TEST_F(Chain, GuessesAndDoubtfulContactsAreNoEnds) {
  contact(10);
  contact(24);
  at(24).by_edge = true;
  complete();
  EXPECT_EQ(found(11, 23), 0);
  at(24).by_edge = false;
  at(24).doubtful = true;
  complete();
  EXPECT_EQ(found(11, 23), 0);
  at(24).doubtful = false;
  complete();
  EXPECT_EQ(found(11, 23), 13);
}

TEST_F(Chain, FloorBehindALineIsNoFace) {
  grainBehind(9, 25);
  for (int beam = 0; beam < sweep.beams(); ++beam)
    std::fill(cost.row(beam), cost.row(beam) + grid.sweepRows(), std::uint16_t{0});
  contact(10);
  contact(24);
  complete();
  EXPECT_EQ(found(11, 23), 0);
}

TEST_F(Chain, SomethingInFrontOfTheEdgeIsNotFloor) {
  for (int beam = 15; beam <= 18; ++beam)
    std::fill(cost.row(beam) + static_cast<int>(sweep.sweepRow(foot(beam))) + 6,
              cost.row(beam) + grid.sweepRows(), std::uint16_t{4 * kernels::cost_unit});
  contact(10);
  contact(24);
  complete();
  EXPECT_EQ(found(11, 23), 0);
}

/// Too little for each of them alone.
TEST_F(Chain, BeamsSayTogetherWhatOneDoesNot) {
  parameters.chain_beams = 6;
  featureAbove(30, 10, 30, 1.5);
  complete();
  for (int beam = 12; beam <= 28; ++beam) {
    ASSERT_TRUE(at(beam).any()) << beam;
    EXPECT_NEAR(at(beam).candidate, foot(beam), 1.0);
    EXPECT_NEAR(sweep.sweepRow(at(beam).candidate) - at(beam).top, 30.0, 2.0);
    EXPECT_LT(at(beam).score, SelectionParameters{}.publish_score);
  }
  EXPECT_EQ(found(0, 4), 0);
  choices.assign(choices.size(), BeamChoice{});
  parameters.chain_beams = 0;
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 0);
}

/// A line on the floor runs into an obstacle: what that shows says nothing of the line.
TEST_F(Chain, OneBeamDoesNotSpeakForAll) {
  parameters.chain_beams = 6;
  featureAbove(30, 20, 22, 9.0);
  featureAbove(40, 20, 22, 9.0);
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 0);
  parameters.chain_share = 100.0;
  complete();
  EXPECT_GT(found(0, sweep.beams() - 1), 10);
}

TEST_F(Chain, APlainFaceWithoutEndsSaysNothing) {
  parameters.chain_beams = 6;
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 0);
}

}  // namespace
}  // namespace ipm_mapping::sweep
