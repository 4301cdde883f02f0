#include "ipm_mapping/sweep/held_contact.hpp"

#include <algorithm>

#include "sweep/plain_wall.hpp"

namespace ipm_mapping::sweep {
namespace {

/// A robot in front of a wall that some beams show, now and then.
class HeldContactTest : public PlainWall {
 protected:
  static constexpr int first = 18, last = 26;
  static constexpr double way = 0.2;  // metres from where the wall is seen to where it is not

  void SetUp() override {
    PlainWall::SetUp();
    choices.assign(static_cast<std::size_t>(sweep.beams()), BeamChoice{});
    parameters.hold_sights = 3;
    held.configure(sweep, parameters);
  }
  /// The wall at `wall` + `way`, seen by its own parallax.
  void see(double seconds, double distance = wall + way) {
    ask(distance);
    for (int beam = first; beam <= last; ++beam) {
      BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
      choice.candidate = static_cast<float>(candidateAt(distance / std::cos(sweep.azimuth(beam))));
      choice.score = 30.0F;
      choice.moving = moving;
      choice.top = static_cast<int>(sweep.sweepRow(choice.candidate)) - support;
      Contact contact;
      contact.bearing = beam;
      answer.contacts.push_back(contact);
      answer.bearings[static_cast<std::size_t>(beam)].state = BearingState::Occupied;
    }
    follow(SE2{}, seconds);
  }
  void seeThrice() {
    for (double seconds : {9.8, 10.1, 10.4}) see(seconds);
  }
  /// From `way` farther on, without a contact of the frame's own; how many beams have one of
  /// before.
  int look(double seconds, BearingState state = BearingState::Unknown, double range = 0.0) {
    ask(wall);
    return lookAgain(seconds, state, range);
  }
  /// The same with the picture as it is.
  int lookAgain(double seconds, BearingState state = BearingState::Unknown, double range = 0.0,
                double x = way) {
    answer.contacts.clear();
    for (Bearing& bearing : answer.bearings) {
      bearing.state = state;
      bearing.range = static_cast<float>(range);
    }
    return follow({x, 0.0, 0.0}, seconds);
  }
  void ask(double distance) {
    paintWall(distance, floor_grey - contrast);
    answer.contacts.clear();
    answer.bearings.assign(choices.size(), Bearing{});
    std::fill(choices.begin(), choices.end(), BeamChoice{});
  }
  int follow(const SE2& T_floor_foot, double seconds) {
    answer.view.stamp = seconds;
    const SweepReference one = reference();
    const CurrentView now = current();
    found = held.follow({now, &one, 1, sweep}, T_floor_foot, new_evidence, choices, answer);
    return static_cast<int>(std::count_if(found.begin(), found.end(),
                                          [](const auto& one) { return one.choice.any(); }));
  }
  [[nodiscard]] double candidateAt(double distance) const {
    return grid.row(distance) / PolarGrid::rows_per_sweep_row - sweep.sweepRow(0.0);
  }

  bool new_evidence = true, moving = false;
  int support = 12;  // rows
  int contrast = floor_grey - wall_grey;
  HeldContact held;
  Obstacles answer;
  std::vector<BeamChoice> choices;
  std::vector<HeldContact::Held> found;
};

TEST_F(HeldContactTest, WhatWasSeenThriceIsHeldWhereTheRobotSeesItNow) {
  seeThrice();
  EXPECT_GE(look(10.6), last - first - 1);
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const auto& [choice, stamp] = found[static_cast<std::size_t>(beam)];
    if (!choice.any()) continue;
    EXPECT_NEAR(choice.candidate, foot(beam), 0.6) << beam;
    EXPECT_EQ(choice.score, 30.0F);
    EXPECT_NEAR(sweep.sweepRow(choice.candidate) - choice.top, 12.0, 1.0) << "as high as it was";
    EXPECT_NEAR(stamp, 10.4, 1e-9) << "of the last sight";
  }
}

TEST_F(HeldContactTest, TwoSightsAreTooFewAndThreeAtOnceAreOne) {
  see(10.0);
  see(10.3);
  EXPECT_EQ(look(10.4), 0);
  held.reset();
  for (double seconds : {10.0, 10.1, 10.2, 10.3, 10.4}) see(seconds);
  EXPECT_EQ(look(10.5), 0);
  see(10.6);
  EXPECT_GT(look(10.7), 0);
}

/// What is seen to be floor beside it does not make a sight of the next frame's.
TEST_F(HeldContactTest, ForgettingOneDoesNotHastenAnother) {
  see(10.0);
  ask(wall + way);
  for (int beam = first; beam < last - 3; ++beam) {
    BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
    choice.candidate =
        static_cast<float>(candidateAt((wall + way) / std::cos(sweep.azimuth(beam))));
    choice.top = static_cast<int>(sweep.sweepRow(choice.candidate)) - 12;
    Contact contact;
    contact.bearing = beam;
    answer.contacts.push_back(contact);
  }
  for (int beam = last - 3; beam <= last; ++beam) {
    Bearing& bearing = answer.bearings[static_cast<std::size_t>(beam)];
    bearing.state = BearingState::Free;
    bearing.range = 2.0F;
  }
  follow(SE2{}, 10.1);
  see(10.4);
  EXPECT_EQ(look(10.5), 0);
}

/// From farther off several beams of before fall into one.
TEST_F(HeldContactTest, OneFrameIsOneSight) {
  constexpr double back = -0.5;
  see(10.0, 0.8);
  see(10.3, 0.8);
  ask(0.8 - back);
  EXPECT_EQ(lookAgain(10.4, BearingState::Unknown, 0.0, back), 0);
  see(10.6, 0.8);
  ask(0.8 - back);
  EXPECT_GT(lookAgain(10.7, BearingState::Unknown, 0.0, back), 0);
}

TEST_F(HeldContactTest, SightsOfDifferentPlacesDoNotAddUp) {
  constexpr double nearer = 0.25;
  seeThrice();
  see(10.7, wall + way - nearer);
  see(11.0, wall + way - nearer);
  ask(wall - nearer);
  EXPECT_EQ(lookAgain(11.1), 0);
  see(11.3, wall + way - nearer);
  ask(wall - nearer);
  EXPECT_GT(lookAgain(11.4), 0);
}

TEST_F(HeldContactTest, WhatHasGoneIsNot) {
  seeThrice();
  ask(wall);
  paint(0, sweep.beams() - 1, floor_grey);
  EXPECT_EQ(lookAgain(10.6), 0);
  EXPECT_GT(look(10.8), 0) << "it only looked that way for a moment";
}

/// Floor of one grey level, or with a line where the wall's foot was: not the step that it made.
TEST_F(HeldContactTest, ALineOnTheFloorIsNotTheWall) {
  seeThrice();
  ask(wall);
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const int row = static_cast<int>(std::lround(sweep.sweepRow(foot(beam))));
    for (int line = sweep.firstLine(beam); line < sweep.firstLine(beam) + kernels::beam_lines;
         ++line)
      for (int j = 0; j < row - 2; ++j)
        grey.at(j, line) = static_cast<std::int16_t>(floor_grey * kernels::grey_unit);
  }
  EXPECT_EQ(lookAgain(10.6), 0);
}

/// However faint: floor of one colour is never the wall.
TEST_F(HeldContactTest, WhatWasHardlyToBeSeenIsNotHeldOnBareFloor) {
  for (int line = 0; line < grid.lines; ++line)
    for (int row = 0; row < grid.sweepRows(); ++row)
      grey.at(row, line) = static_cast<std::int16_t>(floor_grey * kernels::grey_unit);
  const Image<std::int16_t> floor = grey;
  contrast = 2;
  seeThrice();
  grey = floor;
  EXPECT_EQ(lookAgain(10.6), 0);
  EXPECT_GT(look(10.7), 0);
}

/// Above its few rows there is what stands behind it, which moves differently.
TEST_F(HeldContactTest, OfALowThingOnlyItsOwnRowsCount) {
  support = 4;
  seeThrice();
  ask(wall);
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const int top = static_cast<int>(std::lround(sweep.sweepRow(foot(beam)))) - support - 1;
    for (int line = sweep.firstLine(beam); line < sweep.firstLine(beam) + kernels::beam_lines;
         ++line)
      for (int row = 0; row < top; ++row)
        grey.at(row, line) = static_cast<std::int16_t>(200 * kernels::grey_unit);
  }
  EXPECT_GE(lookAgain(10.6), (last - first) / 2);
}

TEST_F(HeldContactTest, BrighterAllOverItIsTheSame) {
  seeThrice();
  ask(wall);
  const int before = lookAgain(10.5);
  for (int line = 0; line < grid.lines; ++line)
    for (int row = 0; row < grid.sweepRows(); ++row)
      grey.at(row, line) = static_cast<std::int16_t>(grey.at(row, line) + 25 * kernels::grey_unit);
  EXPECT_EQ(lookAgain(10.6), before);
}

TEST_F(HeldContactTest, FloorSeenThereForgetsIt) {
  seeThrice();
  EXPECT_GT(look(10.6, BearingState::Free, 0.9 * wall), 0) << "floor up to it";
  EXPECT_GT(look(10.7, BearingState::Free, wall), 0);
  new_evidence = false;
  EXPECT_EQ(look(10.75, BearingState::Free, 1.2 * wall), 0);
  EXPECT_GT(look(10.77), 0) << "a frame that is no evidence forgets nothing";
  new_evidence = true;
  EXPECT_EQ(look(10.8, BearingState::Free, 1.2 * wall), 0);
  EXPECT_EQ(look(10.9), 0);
}

TEST_F(HeldContactTest, ANearerObstacleHidesIt) {
  seeThrice();
  EXPECT_EQ(look(10.6, BearingState::Blocked), 0);
  EXPECT_EQ(look(10.7, BearingState::Occupied, 0.6), 0);
  EXPECT_GT(look(10.8), 0);
}

TEST_F(HeldContactTest, HoldingDoesNotRenewIt) {
  seeThrice();
  for (int k = 0; k < 53; ++k) EXPECT_GT(look(10.5 + 0.1 * k), 0) << k;
  EXPECT_EQ(look(9.8 + parameters.hold_memory + 0.1), 0) << "the first of three is too old";
}

TEST_F(HeldContactTest, WhatMovesOrIsNoNewEvidenceIsNotHeld) {
  moving = true;
  seeThrice();
  EXPECT_EQ(look(10.6), 0);
  held.reset();
  moving = new_evidence = false;
  seeThrice();
  new_evidence = true;
  EXPECT_EQ(look(10.6), 0);
}

/// The lowest rows of the view have no floor in front to compare.
TEST_F(HeldContactTest, AFaceAtTheEndOfTheViewIsComparedAsFarAsItIsSeen) {
  seeThrice();
  const int whole = look(10.6);
  const int row = static_cast<int>(std::lround(sweep.sweepRow(foot((first + last) / 2))));
  endViewAt(row + 1);
  EXPECT_GE(look(10.7), whole / 2);
  endViewAt(row - 13);
  EXPECT_EQ(look(10.8), 0) << "three rows of it";
}

TEST_F(HeldContactTest, SwitchedOffOrResetNothingIsHeld) {
  seeThrice();
  held.reset();
  EXPECT_EQ(look(10.6), 0);
  parameters.hold_sights = 0;
  held.configure(sweep, parameters);
  seeThrice();
  EXPECT_EQ(look(10.6), 0);
}

/// A fast camera on a long drive: nothing is pushed out that is not too old.
TEST_F(HeldContactTest, AFastCameraDoesNotShortenIt) {
  for (int k = 0; k < 3000; ++k) see(10.0 + 0.01 * k);
  EXPECT_GT(look(39.99 + parameters.hold_memory - 0.8), 0);
}

}  // namespace
}  // namespace ipm_mapping::sweep
