#include "ipm_mapping/sweep/straight_foot.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sweep/plain_wall.hpp"

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

/// Runs of beams have contacts.
class Foot : public WallWithContacts {
 protected:
  void contacts(int first, int last, double off = 0.0) {
    for (int beam = first; beam <= last; ++beam) contact(beam, off, support);
  }
  void complete() { WallWithContacts::complete<StraightFoot>(); }

  int support = 24;  // rows
};

TEST_F(Foot, APlainFaceBetweenTwoRunsIsCompleted) {
  contacts(8, 14);
  contacts(30, 36);
  complete();
  for (int beam = 15; beam < 30; ++beam) {
    ASSERT_TRUE(at(beam).any()) << beam;
    EXPECT_NEAR(at(beam).candidate, foot(beam), 1.0) << beam;
    EXPECT_FLOAT_EQ(at(beam).score, 15.0F);
    EXPECT_NEAR(sweep.sweepRow(at(beam).candidate) - at(beam).top, support, 1.0);
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

/// The edge of a rug that a low box stands on looks like its foot.
TEST_F(Foot, ALowRunIsNotContinued) {
  support = 18;  // a fifth of the camera's height is 19 rows
  contacts(8, 14);
  contacts(30, 36);
  complete();
  EXPECT_EQ(found(0, sweep.beams() - 1), 14);
  parameters.foot_support = 0.15;
  complete();
  EXPECT_EQ(found(15, 29), 15) << "nothing else kept it from being continued";
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
