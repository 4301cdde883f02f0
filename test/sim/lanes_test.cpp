#include <gtest/gtest.h>

#include <cmath>

#include "ipm_mapping_sim/rays.hpp"

namespace ipm_mapping::sim {
namespace {

TEST(Lanes, LogarithmAndPowerFollowTheLibrary) {
  for (float x = 1e-4F; x < 1e4F; x *= 1.0173F) {
    EXPECT_NEAR(log2Of(x), std::log2(x), 2e-6F * (1.0F + std::abs(std::log2(x)))) << x;
  }
  for (float x = -20.0F; x < 20.0F; x += 0.0371F) {
    EXPECT_NEAR(exp2Of(x) / std::exp2(x), 1.0F, 1e-6F) << x;
  }
}

TEST(Lanes, FloorIsAtOrBelow) {
  for (const float x : {-2.0F, -1.5F, -0.001F, 0.0F, 0.999F, 7.0F, 7.5F}) {
    EXPECT_EQ(floorOf(x), static_cast<int>(std::floor(x))) << x;
  }
}

TEST(Rays, LanesThatAreNoMembersRepeatTheFirstMember) {
  PixelRays rays, some;
  for (int k = 0; k < kPacket; ++k) {
    const Eigen::Vector3f v = Eigen::Vector3f::Constant(static_cast<float>(k));
    rays.set(k, {v, v, v, v});
  }
  select(rays, 0x0A50, some);
  for (int k = 0; k < kPacket; ++k) {
    const int shown = contains(0x0A50, k) ? k : 4;
    EXPECT_EQ(some.get(k).origin.x(), static_cast<float>(shown)) << k;
    EXPECT_EQ(some.get(k).ddy.z(), static_cast<float>(shown)) << k;
  }
}

TEST(Rays, GroupsAreDisjointAndCoverTheMembers) {
  IntLanes surfaces;
  for (int k = 0; k < kPacket; ++k) surfaces[k] = k % 3 == 0 ? kFloor : k % 5;
  unsigned met = 0;
  forGroups(surfaces, 0xBEEF, [&](int surface, unsigned group) {
    EXPECT_EQ(met & group, 0U);
    met |= group;
    forMembers(group, [&](int k) { EXPECT_EQ(surfaces[k], surface); });
  });
  EXPECT_EQ(met, 0xBEEFU);
}

TEST(Rays, ReachEndsAtTheFloorOrAtTheStage) {
  PixelRays rays;
  const Eigen::Vector3f eye(0.0F, 0.0F, 0.5F), none = Eigen::Vector3f::Zero();
  for (int k = 0; k < kPacket; ++k) rays.set(k, {eye, {1.0F, 0.0F, -0.25F}, none, none});
  rays.set(3, {eye, {1.0F, 0.0F, 0.1F}, none, none});
  rays.set(5, {eye, {1.0F, 0.0F, 0.0F}, none, none});
  rays.reachFloor();
  EXPECT_FLOAT_EQ(rays.reach[0], 2.0F);
  for (const int k : {3, 5}) {
    EXPECT_GT(rays.reach[k], 100.0F) << k;
    EXPECT_LT(rays.reach[k], 1000.0F) << k;
  }
}

}  // namespace
}  // namespace ipm_mapping::sim
