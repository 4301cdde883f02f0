#include "ipm_mapping/sweep/contact_edge.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

/// A score that is flat around its maximum, over an image that is grey but for what a test paints.
class Edge : public ::testing::Test {
 protected:
  static constexpr int beam = 6, centre = 80;

  void SetUp() override {
    const CameraModel camera = test::smallCamera();
    const CameraPose pose = test::smallCameraPose();
    const SweepParameters p = test::smallParameters();
    const PolarGrid grid = makePolarGrid(camera, pose, p.grid, 2.0);
    CylindricalRectification rectification;
    rectification.configure(camera, pose, grid);
    rows = rectification.ranges();
    for (RowRange& range : rows) range = {range.begin / 2 + 2, range.end / 2 - 2};
    sweep.configure(grid, rectification.ranges(), rows, p.grid.max_support, p.evidence);
    grey.resize(grid.sweepRows(), grid.lines, std::int16_t{100 * kernels::grey_unit});
    weight.resize(grid.sweepRows(), grid.lines, std::uint16_t{1});
    scores.score.resize(sweep.candidates(), sweep.beams(), 0.0F);
    scores.top.resize(sweep.candidates(), sweep.beams(), std::int16_t{0});
    for (int c = centre - 12; c <= centre + 12; ++c)
      scores.score.at(c, beam) = 40.0F - 0.02F * static_cast<float>((c - centre) * (c - centre));
  }
  /// Darkens everything in front of a candidate: an edge of the image at its row.
  void darkFrom(int candidate, int by) {
    const int row = static_cast<int>(sweep.sweepRow(candidate));
    for (int line = 0; line < grey.height(); ++line) {
      grey.at(row, line) = static_cast<std::int16_t>((100 - by / 2) * kernels::grey_unit);
      for (int j = row + 1; j < grey.width(); ++j)
        grey.at(j, line) = static_cast<std::int16_t>((100 - by) * kernels::grey_unit);
    }
  }
  float refined() {
    ContactEdge edge;
    edge.configure(parameters);
    std::vector<BeamChoice> choices(static_cast<std::size_t>(sweep.beams()));
    choices[beam].candidate = centre;
    choices[beam].score = 40.0F;
    choices[beam].top = 7;
    edge.refine({grey.view(), weight.view(), &rows}, sweep, scores, choices);
    for (std::size_t i = 0; i < choices.size(); ++i) EXPECT_EQ(choices[i].any(), i == beam);
    top = choices[beam].top;
    return choices[beam].candidate;
  }
  VerticalSweep sweep;
  std::vector<RowRange> rows;
  Image<std::int16_t> grey;
  Image<std::uint16_t> weight;
  SweepScores scores;
  SelectionParameters parameters;
  int top = 0;  // of the refined contact
};

TEST_F(Edge, WithoutAnEdgeTheScoreDecides) { EXPECT_NEAR(refined(), centre, 0.01); }

TEST_F(Edge, AnEdgeOnEitherSideDrawsTheContactToItself) {
  darkFrom(centre + 4, 40);
  EXPECT_NEAR(refined(), centre + 4, 0.3);
  SetUp();
  darkFrom(centre - 3, -40);
  EXPECT_NEAR(refined(), centre - 3, 0.3);
}

TEST_F(Edge, WhereTheContactMovesTheSupportEndsAsItDoesThere) {
  for (int c = 0; c < sweep.candidates(); ++c)
    scores.top.at(c, beam) = static_cast<std::int16_t>(10 + c);
  darkFrom(centre + 4, 40);
  EXPECT_NEAR(refined(), centre + 4, 0.3);
  EXPECT_EQ(top, 10 + centre + 4);
}

/// What the sweep has not followed has no upper end.
TEST_F(Edge, WhereThereIsNoScoreTheSupportEndsAsItDid) {
  for (int c = 0; c < sweep.candidates(); ++c) {
    if (std::abs(c - centre) > 2) scores.score.at(c, beam) = 0.0F;
    scores.top.at(c, beam) = static_cast<std::int16_t>(c == centre ? 7 : 1000);
  }
  scores.score.at(centre, beam) = 1.0F;
  for (int c = centre - 2; c <= centre + 2; ++c) scores.score.at(c, beam) = 1.0F;
  darkFrom(centre + 4, 40);
  EXPECT_NEAR(refined(), centre + 4, 0.6);
  EXPECT_EQ(top, 7);
}

TEST_F(Edge, BeyondItsReachAnEdgeMeansNothing) {
  darkFrom(centre + parameters.edge_nearer + 3, 40);
  EXPECT_NEAR(refined(), centre, 0.01);
  SetUp();
  darkFrom(centre - parameters.edge_farther - 3, 40);
  EXPECT_NEAR(refined(), centre, 0.01);
}

TEST_F(Edge, ASteepScoreIsNotMovedByAFaintEdge) {
  for (int c = centre - 12; c <= centre + 12; ++c)
    scores.score.at(c, beam) = 40.0F - 5.0F * static_cast<float>(std::abs(c - centre));
  darkFrom(centre + 3, 6);
  EXPECT_NEAR(refined(), centre, 0.5);
}

TEST_F(Edge, SwitchedOffNothingMoves) {
  parameters.edge_score = 0.0;
  darkFrom(centre + 4, 40);
  EXPECT_NEAR(refined(), centre, 0.01);
}

TEST_F(Edge, AContactBelowTheImageStays) {
  ContactEdge edge;
  edge.configure(parameters);
  std::vector<BeamChoice> choices(static_cast<std::size_t>(sweep.beams()));
  choices[beam].candidate = static_cast<float>(sweep.candidates() - 1);
  edge.refine({grey.view(), weight.view(), &rows}, sweep, scores, choices);
  EXPECT_EQ(choices[beam].candidate, static_cast<float>(sweep.candidates() - 1));
}

}  // namespace
}  // namespace ipm_mapping::sweep
