#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {

/// A plain wall across the view, one metre from the camera's foot, on plain floor: one edge, no
/// texture, the same in the reference. Both look like floor.
class PlainWall : public ::testing::Test {
 protected:
  static constexpr double wall = 1.0;
  static constexpr int floor_grey = 100, wall_grey = 60;

  void SetUp() override {
    const CameraPose pose = test::smallCameraPose();
    const SweepParameters p = test::smallParameters();
    evidence = p.evidence;
    max_support = p.grid.max_support;
    grid = makePolarGrid(test::smallCamera(), pose, p.grid, 2.0);
    CylindricalRectification rectification;
    rectification.configure(test::smallCamera(), pose, grid);
    reference_rows = rows = rectification.ranges();
    for (RowRange& range : rows) range = {range.begin / 2 + 2, range.end / 2 - 2};
    endViewAt(grid.sweepRows());
    grey.resize(grid.sweepRows(), grid.lines, std::int16_t{});
    weight.resize(grid.sweepRows(), grid.lines, std::uint16_t{20000});
    even.resize(grid.sweepRows(), grid.lines, std::int16_t{wall_grey * kernels::grey_unit});
    odd.resize(grid.sweepRows(), grid.lines, std::int16_t{wall_grey * kernels::grey_unit});
    cost.resize(grid.sweepRows(), sweep.beams(), std::uint16_t{0});
    paint(0, sweep.beams() - 1, wall_grey);
    before_sums.configure(grid.sweepRows(), grid.lines);
    before_sums.evaluate(even.view());
  }
  /// No line sees more than the rows before `end`.
  void endViewAt(int end) {
    for (RowRange& range : rows) range.end = std::min(range.end, end);
    sweep.configure(grid, reference_rows, rows, max_support, evidence);
  }
  /// A wall so far away.
  void paintWall(double distance, int behind) {
    for (int line = 0; line < grid.lines; ++line) {
      const double row = grid.row(distance / std::cos(grid.azimuth(line)));
      for (int j = 0; j < grid.sweepRows(); ++j)
        grey.at(j, line) = static_cast<std::int16_t>(
            kernels::grey_unit * (PolarGrid::rows_per_sweep_row * j < row ? behind : floor_grey));
    }
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
  [[nodiscard]] CurrentView current() {
    sums.configure(grid.sweepRows(), grid.lines, sweep.firstLine(1));
    sums.evaluate(grey.view());
    return {grey.view(), weight.view(), &rows, sums.view()};
  }
  [[nodiscard]] SweepReference reference() const {
    return {even.view(), odd.view(),
            cost.view(), FootMotion({0.15, 0.0, 0.0}, {0.05, -0.01}),
            nullptr,     before_sums.view()};
  }

  PolarGrid grid;
  VerticalSweep sweep;
  std::vector<RowRange> rows, reference_rows;
  EvidenceParameters evidence;
  double max_support = 0.0;
  Image<std::int16_t> grey, even, odd;
  Image<std::uint16_t> weight, cost;
  BeamSums sums, before_sums;
  FootParameters parameters;
};

/// Some beams that see the wall have contacts.
class WallWithContacts : public PlainWall {
 protected:
  void SetUp() override {
    PlainWall::SetUp();
    choices.assign(static_cast<std::size_t>(sweep.beams()), BeamChoice{});
  }
  BeamChoice& at(int beam) { return choices[static_cast<std::size_t>(beam)]; }
  /// A contact `off` candidates from the wall's foot, its support so many rows high.
  void contact(int beam, double off = 0.0, int support = 24) {
    at(beam).candidate = static_cast<float>(foot(beam) + off);
    at(beam).score = 30.0F;
    at(beam).top = static_cast<int>(sweep.sweepRow(at(beam).candidate)) - support;
  }
  /// How many of these beams have one.
  [[nodiscard]] int found(int first, int last) const {
    int n = 0;
    for (int beam = first; beam <= last; ++beam)
      n += choices[static_cast<std::size_t>(beam)].any() ? 1 : 0;
    return n;
  }
  /// Lets a stage complete them.
  template <class Stage>
  void complete() {
    Stage stage;
    stage.configure(sweep, FreeFloorParameters{}, parameters);
    const SweepReference one = reference();
    const CurrentView now = current();
    stage.complete({now, &one, 1, sweep}, choices);
  }

  std::vector<BeamChoice> choices;
};

}  // namespace ipm_mapping::sweep
