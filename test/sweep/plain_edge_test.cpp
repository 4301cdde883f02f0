#include "ipm_mapping/sweep/plain_edge.hpp"

#include "sweep/plain_wall.hpp"

namespace ipm_mapping::sweep {
namespace {

class PlainEdgeLimit : public PlainWall {
 protected:
  static constexpr int middle = 22;
  static constexpr double range = 1.8;

  /// How far the floor of a beam may be called free.
  double limit(int beam) {
    PlainEdge edge;
    edge.configure(sweep, free_floor, parameters);
    const SweepReference one = reference();
    return edge.limit(current(), &one, 1, sweep, beam, range);
  }
  [[nodiscard]] double wallDistance(int beam) const { return wall / std::cos(sweep.azimuth(beam)); }

  FreeFloorParameters free_floor;
};

TEST_F(PlainEdgeLimit, FloorEndsAtAnEdgeBehindWhichNothingIsToBeSeen) {
  for (int beam = 10; beam < sweep.beams() - 10; ++beam)
    EXPECT_NEAR(limit(beam), wallDistance(beam), 0.02) << beam;
}

TEST_F(PlainEdgeLimit, FloorGoesOnBehindALineOnTheFloor) {
  grainBehind(0, sweep.beams() - 1);
  EXPECT_EQ(limit(middle), range);
  parameters.foot_doubt = 1000.0;
  EXPECT_LT(limit(middle), range) << "nothing but the texture told them apart";
}

/// Light falls on it from elsewhere: that alone does not make it floor.
TEST_F(PlainEdgeLimit, AWallThatLooksBrighterThanBeforeIsAWall) {
  paint(0, sweep.beams() - 1, wall_grey + 4);
  for (int beam = 10; beam < sweep.beams() - 10; ++beam)
    EXPECT_NEAR(limit(beam), wallDistance(beam), 0.02) << beam;
  grainBehind(0, sweep.beams() - 1);
  EXPECT_EQ(limit(middle), range);
}

TEST_F(PlainEdgeLimit, AFaintEdgeAndOneBeyondTheRangeAreNotAsked) {
  free_floor.free_edge = 60.0;
  EXPECT_EQ(limit(middle), range);
  free_floor.free_edge = 6.0;
  PlainEdge edge;
  edge.configure(sweep, free_floor, parameters);
  const SweepReference one = reference();
  EXPECT_EQ(edge.limit(current(), &one, 1, sweep, middle, 0.9), 0.9);
}

TEST_F(PlainEdgeLimit, WhereNothingCanBeComparedTheFloorsCostDecidesAlone) {
  std::fill_n(cost.row(0), cost.width() * cost.height(), kernels::no_cost);
  const SweepReference turned_away{even.view(), odd.view(), cost.view(),
                                   FootMotion({0.0, 0.0, 2.5}, {0.05, -0.01})};
  PlainEdge edge;
  edge.configure(sweep, free_floor, parameters);
  EXPECT_EQ(edge.limit(current(), &turned_away, 1, sweep, middle, range), range);
}

}  // namespace
}  // namespace ipm_mapping::sweep
