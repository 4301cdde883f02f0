#include "ipm_mapping/sweep/straight_foot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

TEST(FloorLine, IsTheLineThroughItsPoints) {
  // x cos(0.3) + y sin(0.3) = 1.2 m, seen from 0.45 m up: r = 0.45 / 1.2 cos(azimuth - 0.3)
  const auto r = [](double azimuth) { return 0.45 / 1.2 * std::cos(azimuth - 0.3); };
  const auto direction = [](double azimuth) {
    return Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
  };
  FloorLine line;
  for (const double azimuth : {0.10, 0.12, 0.15}) line.add(direction(azimuth), r(azimuth));
  for (const double azimuth : {-0.6, 0.0, 0.5})
    EXPECT_NEAR(line.r(direction(azimuth)), r(azimuth), 1e-6);
}

/// A plain wall across the view, one metre from the camera's foot, on plain floor: one edge, no
/// texture, the same in the reference. Both look like floor. Some beams have contacts.
class Foot : public ::testing::Test {
 protected:
  static constexpr double wall = 1.0;
  static constexpr int floor_grey = 100, wall_grey = 60;

  void SetUp() override {
    const CameraPose pose = test::smallCameraPose();
    const SweepParameters p = test::smallParameters();
    grid = makePolarGrid(test::smallCamera(), pose, p.grid, 2.0);
    CylindricalRectification rectification;
    rectification.configure(test::smallCamera(), pose, grid);
    rows = rectification.ranges();
    for (RowRange& range : rows) range = {range.begin / 2 + 2, range.end / 2 - 2};
    sweep.configure(grid, rectification.ranges(), rows, p.grid.max_support, p.evidence);
    grey.resize(grid.sweepRows(), grid.lines, std::int16_t{});
    weight.resize(grid.sweepRows(), grid.lines, std::uint16_t{20000});
    even.resize(grid.sweepRows(), grid.lines, std::int16_t{wall_grey * kernels::grey_unit});
    odd.resize(grid.sweepRows(), grid.lines, std::int16_t{wall_grey * kernels::grey_unit});
    cost.resize(grid.sweepRows(), sweep.beams(), std::uint16_t{0});
    paint(0, sweep.beams() - 1, wall_grey);
    choices.assign(static_cast<std::size_t>(sweep.beams()), BeamChoice{});
  }
  /// The wall as some beams see it.
  void paint(int first, int last, int behind) {
    for (int line = sweep.firstLine(first); line < sweep.firstLine(last) + kernels::beam_lines;
         ++line)
      for (int row = 0; row < grid.sweepRows(); ++row)
        grey.at(row, line) = static_cast<std::int16_t>(
            kernels::grey_unit * (PolarGrid::rows_per_sweep_row * row < wallRow(grid.azimuth(line))
                                      ? behind
                                      : floor_grey));
  }
  [[nodiscard]] double wallRow(double azimuth) const { return grid.row(wall / std::cos(azimuth)); }
  /// Candidate at which a beam sees the foot of the wall.
  [[nodiscard]] double foot(int beam) const {
    return wallRow(sweep.azimuth(beam)) / PolarGrid::rows_per_sweep_row - sweep.sweepRow(0.0);
  }
  void contacts(int first, int last, double off = 0.0) {
    for (int beam = first; beam <= last; ++beam) {
      BeamChoice& choice = at(beam);
      choice.candidate = static_cast<float>(foot(beam) + off);
      choice.score = 30.0F;
      choice.top = static_cast<int>(sweep.sweepRow(choice.candidate)) - 12;
    }
  }
  /// Texture that the floor explains and an upright surface does not.
  void grainBehind(int first, int last) {
    std::mt19937 random(3);
    std::uniform_int_distribution<int> grain(-15, 15);
    for (int line = sweep.firstLine(first); line < sweep.firstLine(last) + kernels::beam_lines;
         ++line)
      for (int row = 0; row < grid.sweepRows(); ++row)
        if (PolarGrid::rows_per_sweep_row * (row + 3) < wallRow(grid.azimuth(line)))
          grey.at(row, line) =
              static_cast<std::int16_t>(kernels::grey_unit * (wall_grey + grain(random)));
  }
  void complete() {
    StraightFoot straight_foot;
    straight_foot.configure(sweep, grid.height, SelectionParameters{}, parameters);
    const SweepReference reference{even.view(), odd.view(), cost.view(),
                                   FootMotion({0.15, 0.0, 0.0}, {0.05, -0.01})};
    straight_foot.complete({grey.view(), weight.view(), &rows}, &reference, 1, sweep, choices);
  }
  BeamChoice& at(int beam) { return choices[static_cast<std::size_t>(beam)]; }
  [[nodiscard]] int found(int first, int last) const {
    int n = 0;
    for (int beam = first; beam <= last; ++beam)
      n += choices[static_cast<std::size_t>(beam)].any() ? 1 : 0;
    return n;
  }

  PolarGrid grid;
  VerticalSweep sweep;
  std::vector<RowRange> rows;
  Image<std::int16_t> grey, even, odd;
  Image<std::uint16_t> weight, cost;
  std::vector<BeamChoice> choices;
  StraightFootParameters parameters;
};

TEST_F(Foot, APlainFaceBetweenTwoRunsIsCompleted) {
  contacts(8, 14);
  contacts(30, 36);
  complete();
  for (int beam = 15; beam < 30; ++beam) {
    ASSERT_TRUE(at(beam).any()) << beam;
    EXPECT_NEAR(at(beam).candidate, foot(beam), 1.0) << beam;
    EXPECT_FLOAT_EQ(at(beam).score, 15.0F);
    EXPECT_NEAR(sweep.sweepRow(at(beam).candidate) - at(beam).top, 12.0, 1.0);
  }
  EXPECT_FLOAT_EQ(at(10).score, 30.0F) << "a contact that was there stays as it is";
}

TEST_F(Foot, OneRunIsContinuedByItsReachOnly) {
  contacts(20, 26);  // six steps
  parameters.foot_reach = 1.0;
  complete();
  EXPECT_NEAR(found(14, 19), 6, 1);
  EXPECT_EQ(found(0, 12), 0);
  EXPECT_NEAR(found(27, 32), 6, 1);
  EXPECT_EQ(found(34, sweep.beams() - 1), 0);
}

TEST_F(Foot, SwitchedOffNothingIsAdded) {
  contacts(8, 14);
  contacts(30, 36);
  parameters.foot_reach = 0.0;
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 14);
}

TEST_F(Foot, WhereTheRunsEdgeDoesNotGoOnNothingIsAdded) {
  struct Between {
    const char* what;
    int grey;
  };
  for (const Between& between :
       {Between{"floor, as between two legs", floor_grey},
        Between{"an edge of other polarity", 140}, Between{"a fainter edge", 88}}) {
    SCOPED_TRACE(between.what);
    paint(15, 29, between.grey);
    choices.assign(choices.size(), BeamChoice{});
    contacts(8, 14);
    contacts(30, 36);
    complete();
    EXPECT_EQ(found(16, 28), 0);
  }
}

TEST_F(Foot, WhereTheFloorsTextureGoesOnItIsALineOnTheFloor) {
  grainBehind(15, 29);
  contacts(8, 14);
  contacts(30, 36);
  complete();
  EXPECT_EQ(found(16, 28), 0);
  parameters.foot_doubt = 1000.0;
  complete();
  EXPECT_EQ(found(16, 28), 13) << "nothing else kept them away";
}

TEST_F(Foot, NothingIsAddedBehindWhatIsNotFloor) {
  for (int beam = 15; beam < 30; ++beam)
    for (int row = sweep.rows(beam).end - 20; row < sweep.rows(beam).end; ++row)
      cost.at(row, beam) = static_cast<std::uint16_t>(5 * kernels::cost_unit);
  contacts(8, 14);
  contacts(30, 36);
  complete();
  EXPECT_EQ(found(15, 29), 0);
}

TEST_F(Foot, SomethingElseInTheWayEndsTheWalk) {
  contacts(8, 14);
  contacts(18, 18, 12.0);
  complete();
  EXPECT_EQ(found(15, 17), 3);
  EXPECT_EQ(found(19, sweep.beams() - 1), 0);
}

TEST_F(Foot, AShortRunHasNoDirection) {
  contacts(20, 22);  // four centimetres
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 3);
  parameters.foot_length = 0.0;
  complete();
  EXPECT_GT(found(0, sweep.beams() - 1), 3);
}

TEST_F(Foot, ARoundThingIsNotContinued) {
  contacts(12, 26);
  for (int beam = 12; beam <= 26; ++beam)
    at(beam).candidate -= 0.5F * static_cast<float>((beam - 19) * (beam - 19));
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 15);
}

}  // namespace
}  // namespace ipm_mapping::sweep
