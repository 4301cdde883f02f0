#include "ipm_mapping/sweep/leaning_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

/// Contacts in front of a grained slope that leans away by `lean`, built of thin slices, whose foot
/// lies at x = 1.6; the robot drives 0.4 m towards it.
std::vector<double> feetOf(double lean, const SweepParameters& parameters) {
  test::GrainedScene scene(test::smallCamera(), test::smallCameraPose());
  constexpr double slice = 0.015, foot = 1.6;
  for (int k = 0; k < 20; ++k)
    scene.boxes.push_back({foot + lean * slice * k, 3.2, -0.3, 0.3, slice * (k + 1)});
  const Obstacles obstacles = test::answerAfter(scene, parameters, 0.4);
  std::vector<double> x;
  for (const Contact& contact : obstacles.contacts)
    x.push_back(0.4 + static_cast<double>(contact.p_base.x()) - foot);
  std::sort(x.begin(), x.end());
  return x;
}

double medianOf(const std::vector<double>& sorted) {
  return sorted.empty() ? 1e9 : sorted[sorted.size() / 2];
}

/// Without the image's edge, which would draw the contact to the foot by itself.
SweepParameters withoutEdge() {
  SweepParameters p = test::smallParameters();
  p.selection.edge_score = 0.0;
  return p;
}

TEST(LeaningSurface, ItsFootIsFoundWhereAnUprightOneIsSeenBehindIt) {
  SweepParameters upright = withoutEdge();
  upright.selection.lean_reach = 0;
  const auto behind = feetOf(0.6, upright), found = feetOf(0.6, withoutEdge());
  ASSERT_GT(behind.size(), 5U);
  ASSERT_GT(found.size(), 5U);
  EXPECT_GT(medianOf(behind), 0.03);
  EXPECT_LT(std::abs(medianOf(found)), 0.02);
  EXPECT_LT(std::abs(medianOf(feetOf(0.35, withoutEdge()))), 0.01);
}

TEST(LeaningSurface, AnUprightWallStaysWhereItIs) {
  SweepParameters upright = withoutEdge();
  upright.selection.lean_reach = 0;
  const auto before = feetOf(0.0, upright), after = feetOf(0.0, withoutEdge());
  ASSERT_GT(after.size(), 5U);
  EXPECT_NEAR(medianOf(after), medianOf(before), 0.01);
  EXPECT_LT(std::abs(medianOf(after)), 0.015);
}

}  // namespace
}  // namespace ipm_mapping::sweep
