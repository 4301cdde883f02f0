#include "ipm_mapping/sweep/bearing_selection.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

class Selection : public ::testing::Test {
 protected:
  void SetUp() override {
    const CameraModel camera = test::smallCamera();
    const CameraPose pose = test::smallCameraPose();
    const SweepParameters p = test::smallParameters();
    const PolarGrid grid = makePolarGrid(camera, pose, p.grid, 2.0);
    CylindricalRectification rectification;
    rectification.configure(camera, pose, grid);
    NoiseModel noise;
    noise.configure(grid, rectification.ranges(), p.noise);
    sweep.configure(grid, rectification.ranges(), noise.sweepRows(), p.grid.max_support,
                    p.evidence);
    parameters.publish_slope = 0.0;
    scores.score.resize(sweep.candidates(), sweep.beams(), 0.0F);
    scores.top.resize(sweep.candidates(), sweep.beams(), 10000);
  }
  /// A triangle of evidence around a candidate, its support reaching `rows` up.
  void peak(int beam, int candidate, float score, int rows = 30) {
    for (int c = candidate - 4; c <= candidate + 4; ++c) {
      scores.score.at(c, beam) =
          score * (1.0F - 0.2F * static_cast<float>(std::abs(c - candidate)));
      scores.top.at(c, beam) =
          static_cast<std::int16_t>(sweep.sweepRow(c) - static_cast<double>(rows));
    }
  }
  std::vector<BeamChoice> select() {
    BearingSelection selection;
    selection.configure(sweep, 0.45, parameters);
    std::vector<BeamChoice> choices;
    selection.select(scores, choices);
    return choices;
  }
  VerticalSweep sweep;
  SelectionParameters parameters;
  SweepScores scores;
};

TEST_F(Selection, NoEvidenceNoContact) {
  for (const BeamChoice& choice : select()) EXPECT_FALSE(choice.any());
}

TEST_F(Selection, AWallIsFoundAtEveryBeamOfIt) {
  for (int beam = 5; beam < 15; ++beam) peak(beam, 50 + beam / 3, 40.0F);
  const auto choices = select();
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
    EXPECT_EQ(choice.any(), beam >= 5 && beam < 15) << beam;
    if (choice.any()) {
      EXPECT_NEAR(choice.candidate, 50 + beam / 3, 0.01) << beam;
    }
  }
}

TEST_F(Selection, AFaintPeakSurvivesBesideItsLikeButNotAlone) {
  for (int beam = 4; beam < 10; ++beam) peak(beam, 60, 11.0F);
  peak(16, 60, 11.0F);
  const auto choices = select();
  for (int beam = 4; beam < 10; ++beam) EXPECT_TRUE(choices[static_cast<std::size_t>(beam)].any());
  EXPECT_FALSE(choices[16].any());
}

TEST_F(Selection, WhatStandsBehindAClearNearerObstacleIsHidden) {
  for (int beam = 3; beam < 12; ++beam) {
    peak(beam, 40, 80.0F, 20);
    peak(beam, 90, 30.0F, 40);
  }
  const auto choices = select();
  for (int beam = 3; beam < 12; ++beam)
    EXPECT_NEAR(choices[static_cast<std::size_t>(beam)].candidate, 90, 0.01) << beam;
}

TEST_F(Selection, AnUnclearNearerPeakDoesNotHideAStrongOne) {
  for (int beam = 3; beam < 12; ++beam) {
    peak(beam, 40, 80.0F, 20);
    peak(beam, 90, 9.0F, 40);
  }
  const auto choices = select();
  for (int beam = 3; beam < 12; ++beam)
    EXPECT_NEAR(choices[static_cast<std::size_t>(beam)].candidate, 40, 0.01) << beam;
}

TEST_F(Selection, TheMaximumIsFoundBetweenCandidates) {
  for (int beam = 3; beam < 12; ++beam) {
    for (int c = 60; c <= 70; ++c) {
      const double offset = c - 65.3;
      scores.score.at(c, beam) = static_cast<float>(50.0 - 2.0 * offset * offset);
      scores.top.at(c, beam) = static_cast<std::int16_t>(sweep.sweepRow(30));
    }
  }
  for (const BeamChoice& choice : select()) {
    if (choice.any()) {
      EXPECT_NEAR(choice.candidate, 65.3, 1e-3);
    }
  }
  EXPECT_TRUE(select()[5].any());
}

TEST_F(Selection, AContactThatStraddlesAnEdgeIsDroppedAndARecedingWallIsNot) {
  for (int beam = 3; beam < 9; ++beam) peak(beam, 80, 60.0F);
  peak(9, 62, 30.0F);  // between the obstacle and nothing
  EXPECT_FALSE(select()[9].any());
  for (int beam = 10; beam < 14; ++beam) peak(beam, 62, 30.0F);  // a wall behind it, confirmed
  EXPECT_TRUE(select()[9].any());
  EXPECT_TRUE(select()[11].any());
}

TEST_F(Selection, BetweenNearerContactsOnBothSidesNothingIsSeenHoweverStrong) {
  for (int beam = 3; beam < 14; ++beam) peak(beam, beam == 8 ? 62 : 80, beam == 8 ? 60.0F : 30.0F);
  EXPECT_FALSE(select()[8].any());
  EXPECT_TRUE(select()[7].any());
  for (int beam = 6; beam < 11; ++beam) peak(beam, 62, 60.0F), peak(beam, 80, 0.0F);
  EXPECT_TRUE(select()[8].any()) << "a gap that something passes through";
}

/// Cheapest sequence of states by trying all of them, on a handful of beams and candidates.
TEST_F(Selection, ThePathIsTheCheapestOfAllPaths) {
  const int beams = 4, base = 50, width = 4;
  parameters.straddle = false;
  parameters.refine_steps = 0;
  parameters.publish_score = 0.5;
  parameters.nearer_score = 1e6;  // no erasing: only the path counts
  parameters.score_cap = 1000.0;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(0.6F, 20.0F);
  for (int trial = 0; trial < 20; ++trial) {
    scores.score.resize(sweep.candidates(), sweep.beams(), 0.0F);
    for (int beam = 0; beam < beams; ++beam)
      for (int c = base; c < base + width; ++c) scores.score.at(c, beam) = value(random);
    const auto choices = select();
    const auto entry = [&](int a, int b) {  // -1 is 'nothing'
      if (a < 0 && b < 0) return 0.0;
      if (a < 0 || b < 0) return parameters.nothing_cost;
      return std::min(parameters.step_cost * std::abs(a - b), parameters.jump_cost);
    };
    const auto own = [&](int beam, int c) {
      return c < 0 ? 0.0 : parameters.presence_cost - static_cast<double>(scores.score.at(c, beam));
    };
    double cheapest = 1e9;
    std::vector<int> path(beams);
    std::function<void(int, int, double)> extend = [&](int beam, int last, double cost) {
      if (beam == beams) {
        cheapest = std::min(cheapest, cost + entry(last, -1));
        return;
      }
      extend(beam + 1, -1, cost + entry(last, -1));
      for (int c = base; c < base + width; ++c)
        extend(beam + 1, c, cost + entry(last, c) + own(beam, c));
    };
    extend(0, -1, 0.0);
    double got = 0.0;
    int last = -1;
    for (int beam = 0; beam < beams; ++beam) {
      const BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
      const int c = choice.any() ? static_cast<int>(std::lround(choice.candidate)) : -1;
      got += entry(last, c) + own(beam, c);
      last = c;
    }
    EXPECT_NEAR(got + entry(last, -1), cheapest, 1e-4) << trial;
  }
}

}  // namespace
}  // namespace ipm_mapping::sweep
