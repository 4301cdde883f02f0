#include "ipm_mapping/sweep/remembered_foot.hpp"

#include "sweep/plain_wall.hpp"

namespace ipm_mapping::sweep {
namespace {

/// A robot that drives towards the wall: some beams show it at the start, none later.
class Remembered : public PlainWall {
 protected:
  static constexpr int first = 18, last = 26;
  static constexpr double way = 0.2;  // metres from the first frame to the next

  void SetUp() override {
    PlainWall::SetUp();
    choices.assign(static_cast<std::size_t>(sweep.beams()), BeamChoice{});
  }
  void configure() { remembered.configure(sweep, FreeFloorParameters{}, parameters); }
  /// The wall, 1.2 m away, seen by its own texture, or guessed by its edge. Its picture is that of
  /// a wall at 1.2 m.
  void see(double stamp, bool by_edge = false, bool doubtful = false) {
    see(stamp, first, last, by_edge, doubtful);
  }
  void see(double stamp, int from, int to, bool by_edge, bool doubtful) {
    clear();
    const Image<std::int16_t> later = grey;
    paintWall(wall + way, wall_grey);
    for (int beam = from; beam <= to; ++beam) {
      BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
      choice.candidate = static_cast<float>(candidateAt((wall + way) / std::cos(azimuth(beam))));
      choice.score = 30.0F;
      choice.by_edge = by_edge;
      choice.doubtful = doubtful;
      choice.top = static_cast<int>(sweep.sweepRow(choice.candidate)) - 12;
    }
    complete({0.0, 0.0, 0.0}, stamp);
    grey = later;
  }
  /// Twenty centimetres nearer, without a contact of this frame's own.
  int look(double stamp) {
    clear();
    complete({way, 0.0, 0.0}, stamp);
    int found = 0;
    for (const BeamChoice& choice : choices) found += choice.any() ? 1 : 0;
    return found;
  }
  void complete(const SE2& T_floor_foot, double stamp) {
    const SweepReference one = reference();
    const CurrentView now = current();
    remembered.complete({now, &one, 1, sweep}, T_floor_foot, stamp, new_evidence, choices);
  }
  void clear() { std::fill(choices.begin(), choices.end(), BeamChoice{}); }
  [[nodiscard]] double azimuth(int beam) const { return sweep.azimuth(beam); }
  [[nodiscard]] double candidateAt(double distance) const {
    return grid.row(distance) / PolarGrid::rows_per_sweep_row - sweep.sweepRow(0.0);
  }

  bool new_evidence = true;
  RememberedFoot remembered;
  std::vector<BeamChoice> choices;
};

TEST_F(Remembered, AWallThatShowedItselfIsFoundByItsFootFromNearer) {
  configure();
  see(10.0);
  EXPECT_GT(look(10.5), last - first - 2);
  int within = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
    if (!choice.any()) continue;
    EXPECT_NEAR(choice.candidate, candidateAt(wall / std::cos(azimuth(beam))), 1.0) << beam;
    EXPECT_FLOAT_EQ(choice.score, 15.0F);
    ++within;
  }
  EXPECT_GT(within, 0);
}

/// However often: what stands alone or is low is not looked for by its edge.
TEST_F(Remembered, WhatIsDoubtfulIsNotFoundAgain) {
  configure();
  see(10.0, false, true);
  see(10.1, false, true);
  EXPECT_EQ(look(10.5), 0);
  see(10.6);
  EXPECT_GT(look(10.7), last - first - 2);
}

TEST_F(Remembered, ItIsForgottenAfterAWhileAndAFindDoesNotRenewIt) {
  parameters.foot_memory = 2.0;
  configure();
  see(10.0);
  EXPECT_GT(look(11.5), 0);
  EXPECT_EQ(look(12.5), 0);
}

TEST_F(Remembered, AGuessHasToBeMadeTwice) {
  configure();
  see(10.0, true);
  EXPECT_EQ(look(10.1), 0);
  see(10.2, true);
  EXPECT_GT(look(10.3), 0);
}

/// What a robot that stands sees is found by its memory, and does not feed it.
TEST_F(Remembered, WhatIsNoNewEvidenceIsNotRemembered) {
  configure();
  new_evidence = false;
  for (int k = 0; k < 5; ++k) see(10.0 + 0.1 * k);
  EXPECT_EQ(look(10.5), 0);
  new_evidence = true;
  see(10.6);
  new_evidence = false;
  EXPECT_GT(look(10.7), last - first - 2);
}

/// One side of the wall is seen five hundred times more.
TEST_F(Remembered, AFastCameraDoesNotShortenIt) {
  parameters.foot_memory = 3.0;
  configure();
  see(10.0);
  const int known = look(12.9);
  configure();
  see(10.0);
  for (int k = 1; k <= 500; ++k) see(10.0 + 0.005 * k, first, (first + last) / 2, false, false);
  EXPECT_EQ(look(12.9), known);
}

TEST_F(Remembered, AResetForgetsEverything) {
  configure();
  see(10.0);
  remembered.reset();
  EXPECT_EQ(look(10.5), 0);
}

TEST_F(Remembered, SwitchedOffNothingIsAdded) {
  parameters.foot_memory = 0.0;
  configure();
  see(10.0);
  EXPECT_EQ(look(10.5), 0);
}

TEST_F(Remembered, WithoutItsEdgeThereIsNoContact) {
  configure();
  see(10.0);
  paint(0, sweep.beams() - 1, floor_grey);  // it was carried away
  EXPECT_EQ(look(10.5), 0);
}

TEST_F(Remembered, WhereTheFloorGoesOnThereIsNone) {
  configure();
  see(10.0);
  grainBehind(0, sweep.beams() - 1);
  EXPECT_EQ(look(10.5), 0);
}

}  // namespace
}  // namespace ipm_mapping::sweep
