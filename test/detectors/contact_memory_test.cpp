#include "ipm_mapping/detectors/contact_memory.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "support/fan_world.hpp"

namespace ipm_mapping::test {
namespace {

constexpr double start = 100.0;

/// A memory that is told what a faultless detector sees, then asked without new evidence.
class Memory : public ::testing::Test {
 protected:
  void see(const SE2& pose, double stamp) {
    Obstacles seen = world.seenFrom(pose, stamp);
    ASSERT_TRUE(memory.follow(frame(pose, stamp), FrameStatus::Used, seen));
    views.push_back(seen);
  }
  /// The robot has stood since `start`, and looks on.
  template <class Change>
  void lookOn(const SE2& pose, double stamp, const Change& change) {
    recalled = world.seenFrom(pose, stamp);
    recalled.age = static_cast<float>(stamp - start);
    change(recalled);
    ASSERT_TRUE(memory.follow(frame(pose, stamp), FrameStatus::Watched, recalled));
  }
  /// Misses what stands there, and sees no floor either.
  static void blind(Obstacles& seen) {
    seen.contacts.clear();
    for (Bearing& bearing : seen.bearings)
      if (bearing.state == BearingState::Occupied) bearing.state = BearingState::Unknown;
  }
  void lookOn(const SE2& pose, double stamp) {
    lookOn(pose, stamp, [](Obstacles&) {});
  }
  bool recall(const SE2& pose, double stamp, FrameStatus status = FrameStatus::NoMotion) {
    return memory.follow(frame(pose, stamp), status, recalled);
  }
  static Frame frame(const SE2& pose, double stamp) { return {7, stamp, GrayView{}, pose}; }

  /// The rule, spelt out: the newest view that looked at a place decides.
  [[nodiscard]] bool freeBySlowRule(const Eigen::Vector2d& p_odom) const {
    for (auto seen = views.rbegin(); seen != views.rend(); ++seen) {
      const Eigen::Vector2d p = seen->view.T_odom_base.inverse() * p_odom;
      const Eigen::Vector2d d = p - seen->view.cameraFoot();
      const double angle = std::atan2(d.y(), d.x());
      const double spacing = FanWorld::angle(0) - FanWorld::angle(1);
      const Bearing* nearest = nullptr;
      for (const Bearing& bearing : seen->bearings)
        if (nearest == nullptr ||
            std::abs(bearing.angle - angle) < std::abs(nearest->angle - angle))
          nearest = &bearing;
      if (std::abs(nearest->angle - angle) > 0.5 * spacing || d.norm() < nearest->near) continue;
      return d.norm() <= nearest->range;
    }
    return false;
  }
  [[nodiscard]] double freeEndBySlowRule(const SE2& pose, const Bearing& bearing) const {
    const Eigen::Vector2d foot = world.T_base_camera.translation().head<2>();
    const Eigen::Vector2d ahead(std::cos(bearing.angle), std::sin(bearing.angle));
    double range = bearing.near;
    while (freeBySlowRule(pose * Eigen::Vector2d(foot + (range + 1e-3) * ahead)) &&
           (foot + (range + 1e-3) * ahead).norm() <= FanWorld::max_range)
      range += 1e-3;
    return range;
  }
  [[nodiscard]] int count(BearingState state) const {
    return static_cast<int>(std::count_if(recalled.bearings.begin(), recalled.bearings.end(),
                                          [state](const Bearing& b) { return b.state == state; }));
  }

  FanWorld world{{{{1.6, 0.3}, 0.2}, {{1.5, -0.5}, 0.15}}};
  ContactMemory memory{MemoryParameters{}};
  std::vector<Obstacles> views;  // oldest first
  Obstacles recalled;
};

TEST_F(Memory, StandingHoldsTheAnswerAsItWas) {
  const SE2 pose{0.3, -0.2, 0.1};
  see(pose, start);
  ASSERT_TRUE(recall(pose, start + 1.5));
  const Obstacles& seen = views.back();
  EXPECT_FLOAT_EQ(recalled.age, 1.5F);
  EXPECT_EQ(recalled.frame, 7U);
  EXPECT_EQ(recalled.view.stamp, start + 1.5);
  ASSERT_EQ(recalled.bearings.size(), seen.bearings.size());
  for (std::size_t i = 0; i < seen.bearings.size(); ++i) {
    EXPECT_EQ(recalled.bearings[i].state, seen.bearings[i].state) << i;
    EXPECT_NEAR(recalled.bearings[i].range, seen.bearings[i].range, 1e-3) << i;
    EXPECT_EQ(recalled.bearings[i].angle, seen.bearings[i].angle);
    EXPECT_NEAR(recalled.bearings[i].near, seen.bearings[i].near, 1e-6);
  }
  ASSERT_GT(seen.contacts.size(), 20U);
  ASSERT_EQ(recalled.contacts.size(), seen.contacts.size());
  for (std::size_t i = 0; i < seen.contacts.size(); ++i) {
    EXPECT_TRUE(recalled.contacts[i].p_base.isApprox(seen.contacts[i].p_base, 1e-5F));
    EXPECT_EQ(recalled.contacts[i].bearing, seen.contacts[i].bearing);
    EXPECT_FLOAT_EQ(recalled.contacts[i].age, 1.5F);
    EXPECT_EQ(recalled.contacts[i].score, 20.0F);
    const auto pixel = recalled.view.currentFloor().pixel(seen.contacts[i].p_base.cast<double>());
    EXPECT_NEAR(recalled.contacts[i].u, pixel->x(), 0.01);
    EXPECT_NEAR(recalled.contacts[i].v, pixel->y(), 0.01);
  }
}

TEST_F(Memory, OfARobotThatLooksOnTheNewestIsWhatItSees) {
  const FanWorld before = world;
  see({}, start);
  world.discs.erase(world.discs.begin());  // one leaves, and somebody comes
  world.discs.push_back({{1.2, 0.6}, 0.1});
  lookOn({}, start + 1.0);
  EXPECT_FLOAT_EQ(recalled.age, 1.0F) << "since there was new evidence";
  const Obstacles now = world.seenFrom({}, start + 1.0);
  ASSERT_EQ(recalled.contacts.size(), now.contacts.size());
  for (std::size_t i = 0; i < now.contacts.size(); ++i) {
    EXPECT_TRUE(recalled.contacts[i].p_base.isApprox(now.contacts[i].p_base, 1e-5F));
    EXPECT_GT(recalled.contacts[i].age, 0.0F);
    EXPECT_LT(recalled.contacts[i].age, 0.01F) << "seen just now";
  }
  for (std::size_t i = 0; i < now.bearings.size(); ++i) {
    EXPECT_EQ(recalled.bearings[i].state, now.bearings[i].state) << i;
    EXPECT_NEAR(recalled.bearings[i].range, now.bearings[i].range, 1e-3) << i;
  }
  // who looks on no more goes on from there
  ASSERT_TRUE(recall({}, start + 3.0));
  EXPECT_FLOAT_EQ(recalled.age, 3.0F);
  ASSERT_EQ(recalled.contacts.size(), now.contacts.size());
  EXPECT_FLOAT_EQ(recalled.contacts.front().age, 2.0F);
  world = before;
}

TEST_F(Memory, WhatALookerOnMissesIsHeldUntilFloorIsSeenThere) {
  see({}, start);
  const std::size_t all = views.back().contacts.size();
  // two views, so that looking on does not take the place of the only one
  see({0.01, 0.0, 0.0}, start + 0.1);
  lookOn({0.01, 0.0, 0.0}, start + 1.0, blind);
  EXPECT_GE(recalled.contacts.size(), all - 2);
  for (const Contact& contact : recalled.contacts) EXPECT_GT(contact.age, 0.9F);
  world.discs.clear();
  lookOn({0.01, 0.0, 0.0}, start + 1.1);
  EXPECT_TRUE(recalled.contacts.empty());
}

TEST_F(Memory, OfALookerOnReachesBackAsFarAsEverHoweverLongItStands) {
  see({}, start);
  const std::size_t all = views.back().contacts.size();
  double t = start;
  for (; t < start + 25.0; t += 0.5) lookOn({}, t + 0.5);
  ASSERT_EQ(recalled.contacts.size(), all);
  const double seen_last = t;
  for (; t < seen_last + 9.0; t += 0.5) lookOn({}, t + 0.5, blind);
  EXPECT_EQ(recalled.contacts.size(), all);
  EXPECT_NEAR(recalled.contacts.front().age, t - seen_last, 0.01);
  for (; t < seen_last + 11.0; t += 0.5) lookOn({}, t + 0.5, blind);
  EXPECT_TRUE(recalled.contacts.empty());
}

TEST_F(Memory, WithoutItALookerOnTellsWhatItSees) {
  MemoryParameters none;
  none.hold = 0.0;
  memory = ContactMemory(none);
  see({}, start);
  lookOn({}, start + 1.0);
  EXPECT_EQ(recalled.contacts.size(), views.back().contacts.size());
  EXPECT_FLOAT_EQ(recalled.age, 1.0F);
  EXPECT_FALSE(recall({}, start + 1.1));
}

TEST_F(Memory, HoldsAsWellBehindTheRobotWhereAnglesWrap) {
  world.facing = M_PI;
  world.T_base_camera = cameraPose(-0.05, 0.0, 0.45, 0.42, M_PI);
  for (FanWorld::Disc& disc : world.discs) disc.centre = -disc.centre;
  see({}, start);
  ASSERT_GT(views.back().contacts.size(), 20U);
  ASSERT_TRUE(recall({}, start + 1.0));
  ASSERT_EQ(recalled.contacts.size(), views.back().contacts.size());
  for (std::size_t i = 0; i < recalled.bearings.size(); ++i) {
    EXPECT_EQ(recalled.bearings[i].state, views.back().bearings[i].state) << i;
    EXPECT_NEAR(recalled.bearings[i].range, views.back().bearings[i].range, 1e-3) << i;
  }
}

TEST_F(Memory, FreeFloorExpiresBeforeContactsAndContactsExpireToo) {
  const MemoryParameters parameters;
  see({}, start);
  ASSERT_TRUE(recall({}, start + parameters.hold_free));
  EXPECT_GT(count(BearingState::Free), 10);
  const std::size_t contacts = recalled.contacts.size();
  ASSERT_TRUE(recall({}, start + parameters.hold_free + 0.01));
  EXPECT_EQ(count(BearingState::Free), 0);
  EXPECT_EQ(recalled.contacts.size(), contacts);
  for (const Bearing& bearing : recalled.bearings) {
    if (bearing.state == BearingState::Occupied) {
      EXPECT_EQ(bearing.near, bearing.range) << "floor in front of it is not known any more";
    }
  }
  ASSERT_TRUE(recall({}, start + parameters.hold));
  EXPECT_FALSE(recall({}, start + parameters.hold + 0.01));
  EXPECT_TRUE(recalled.bearings.empty());
  EXPECT_TRUE(recalled.contacts.empty());
}

TEST_F(Memory, WhatMovesIsHeldNoLongerThanFreeFloor) {
  const MemoryParameters parameters;
  Obstacles seen = world.seenFrom({}, start);
  ASSERT_GE(seen.contacts.size(), 2U);
  seen.contacts[0].moving = true;
  ASSERT_TRUE(memory.follow(frame({}, start), FrameStatus::Used, seen));
  ASSERT_TRUE(recall({}, start + parameters.hold_free));
  EXPECT_EQ(recalled.contacts.size(), seen.contacts.size());
  ASSERT_TRUE(recall({}, start + parameters.hold_free + 0.01));
  EXPECT_EQ(recalled.contacts.size(), seen.contacts.size() - 1);
  for (const Contact& contact : recalled.contacts) EXPECT_FALSE(contact.moving);
}

TEST_F(Memory, WhatMovesIsOnlyWhereItWasLast) {
  FanWorld before{{{{1.6, 0.5}, 0.15}}}, now{{{{1.6, -0.3}, 0.15}}};
  for (int k = 0; k < 2; ++k) {
    const double stamp = start + 0.5 * k, x = 0.3 * k;
    Obstacles seen = (k == 0 ? before : now).seenFrom({x, 0.0, 0.0}, stamp);
    for (Contact& contact : seen.contacts) contact.moving = true;
    for (Bearing& bearing : seen.bearings)  // nobody has seen floor where it was
      if (bearing.angle > 0.1F) bearing.state = BearingState::Unknown;
    ASSERT_TRUE(memory.follow(frame({x, 0.0, 0.0}, stamp), FrameStatus::Used, seen));
  }
  ASSERT_TRUE(recall({0.3, 0.0, 0.0}, start + 0.6));
  ASSERT_FALSE(recalled.contacts.empty());
  for (const Contact& contact : recalled.contacts) EXPECT_LT(contact.p_base.y(), 0.0F);
}

TEST_F(Memory, NothingHoldsFarFromWhereItWasSeen) {
  const MemoryParameters parameters;
  see({}, start);
  EXPECT_TRUE(recall({parameters.hold_distance - 0.01, 0, 0}, start + 1, FrameStatus::NoReference));
  EXPECT_FALSE(
      recall({parameters.hold_distance + 0.01, 0, 0}, start + 1, FrameStatus::NoReference));
}

TEST_F(Memory, TurningOnTheSpotMovesWhatWasSeenThroughTheView) {
  for (double x = 0.0; x < 0.6; x += 0.04) see({x, 0.0, 0.0}, start + x);
  for (const double turn : {-0.7, -0.31, 0.013, 0.2, 0.55, 1.0}) {
    const SE2 pose{0.56, 0.0, turn};
    ASSERT_TRUE(recall(pose, start + 1.0, FrameStatus::TooMuchRotation));
    for (const Contact& contact : recalled.contacts) {
      const Eigen::Vector2d p = pose * contact.p_base.cast<double>();
      const double gap = std::min(std::abs((p - world.discs[0].centre).norm() - 0.2),
                                  std::abs((p - world.discs[1].centre).norm() - 0.15));
      EXPECT_LT(gap, 1e-5);
      const Eigen::Vector2f d = contact.p_base - recalled.view.cameraFoot().cast<float>();
      const Bearing& bearing = recalled.bearings[static_cast<std::size_t>(contact.bearing)];
      EXPECT_NEAR(std::atan2(d.y(), d.x()), bearing.angle, 0.6 * (2 * FanWorld::half_view / 60));
      EXPECT_EQ(bearing.state, BearingState::Occupied);
      EXPECT_NEAR(bearing.range, d.norm(), 1e-5F);
    }
    EXPECT_GT(count(BearingState::Unknown), std::abs(turn) > 0.6 ? 5 : -1) << turn;
  }
}

TEST_F(Memory, FreeFloorIsThatOfTheSlowRule) {
  world.discs.push_back({{0.9, 0.45}, 0.1});
  // Far enough apart that the memory keeps every view.
  for (int k = 0; k < 5; ++k) see({0.1 * k, 0.0, 0.0}, start + 0.1 * k);
  int asked = 0;
  for (const double turn : {-0.4, -0.11, 0.0, 0.07, 0.33}) {
    const SE2 pose{0.4, 0.0, turn};
    ASSERT_TRUE(recall(pose, start + 1.0));
    for (const Bearing& bearing : recalled.bearings) {
      if (bearing.state != BearingState::Free) continue;
      EXPECT_NEAR(bearing.range, freeEndBySlowRule(pose, bearing), 2.1e-3) << turn;
      ++asked;
    }
  }
  EXPECT_GT(asked, 80);
}

TEST_F(Memory, DoesNotDependOnWhereTheOdometryBeganNorOnTheClock) {
  const SE2 moved{-3.0, 8.0, 2.9};
  const auto run = [&](const SE2& origin, double shift) {
    memory.clear();
    views.clear();
    FanWorld there = world;
    for (auto& disc : there.discs) disc.centre = origin * disc.centre;
    std::swap(world, there);
    for (double x = 0.0; x < 0.5; x += 0.04) see(origin * SE2{x, 0.0, 0.0}, start + shift + x);
    std::swap(world, there);
    EXPECT_TRUE(recall(origin * SE2{0.48, 0.0, 0.4}, start + shift + 1.0));
    return recalled;
  };
  const Obstacles a = run({}, 0.0), b = run(moved, -50.0);
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  ASSERT_GT(a.contacts.size(), 5U);
  for (std::size_t i = 0; i < a.contacts.size(); ++i)
    EXPECT_LT((a.contacts[i].p_base - b.contacts[i].p_base).norm(), 1e-4F);
  int same = 0;
  for (std::size_t i = 0; i < a.bearings.size(); ++i)
    same += a.bearings[i].state == b.bearings[i].state &&
            std::abs(a.bearings[i].range - b.bearings[i].range) < 2e-3F;
  EXPECT_GE(same, static_cast<int>(a.bearings.size()) - 1) << "rounding may move one sector's edge";
}

TEST_F(Memory, FloorSeenLaterTakesAContactBack) {
  see({0.0, 0.0, 0.0}, start);
  world.discs.clear();  // somebody took them away
  see({0.2, 0.0, 0.0}, start + 1.0);
  ASSERT_TRUE(recall({0.2, 0.0, 0.0}, start + 1.5));
  EXPECT_TRUE(recalled.contacts.empty());
  EXPECT_EQ(count(BearingState::Free), FanWorld::bearings);
}

TEST_F(Memory, WhatTheLastFrameDidNotLookAtComesFromEarlierOnes) {
  world.discs = {{{1.0, 0.4}, 0.1}};
  see({0.0, 0.0, 0.0}, start);
  see({0.1, 0.0, 0.0}, start + 0.2);
  see({0.4, 0.0, -0.2}, start + 0.8);
  ASSERT_TRUE(views.back().contacts.empty()) << "out of the last view";
  ASSERT_TRUE(recall({0.4, 0.0, 0.3}, start + 2.0, FrameStatus::TooMuchRotation));
  ASSERT_FALSE(recalled.contacts.empty());
  for (const Contact& contact : recalled.contacts) EXPECT_GT(contact.age, 1.7F);
  EXPECT_FLOAT_EQ(recalled.age, 1.2F) << "of the newest frame that holds";
}

TEST_F(Memory, ADirectionOnceBlockedStaysBlocked) {
  Obstacles seen = world.seenFrom({}, start);
  for (int i = 30; i < 40; ++i) {
    Bearing& bearing = seen.bearings[static_cast<std::size_t>(i)];
    bearing.state = BearingState::Blocked;
    bearing.range = 0.0F;
  }
  const auto on_free = [](const Contact& c) { return c.bearing >= 30 && c.bearing < 40; };
  seen.contacts.erase(std::remove_if(seen.contacts.begin(), seen.contacts.end(), on_free),
                      seen.contacts.end());
  memory.follow(frame({}, start), FrameStatus::Used, seen);
  const double spacing = FanWorld::angle(0) - FanWorld::angle(1);
  ASSERT_TRUE(recall({0.0, 0.0, 5 * spacing}, start + 5.0, FrameStatus::TooMuchRotation));
  for (int i = 0; i < FanWorld::bearings; ++i)
    EXPECT_EQ(recalled.bearings[static_cast<std::size_t>(i)].state == BearingState::Blocked,
              i >= 35 && i < 45)
        << i;
}

TEST_F(Memory, ForgetsWhenToldAndHoldsNothingWhenOff) {
  see({}, start);
  memory.clear();
  EXPECT_FALSE(recall({}, start + 0.1));
  MemoryParameters off;
  off.hold = 0.0;
  memory = ContactMemory(off);
  see({}, start);
  EXPECT_FALSE(recall({}, start + 0.1));
}

TEST_F(Memory, IsNotAskedWhenTheFrameItselfWasUnusable) {
  see({}, start);
  for (const FrameStatus status : {FrameStatus::NoCamera, FrameStatus::SizeMismatch,
                                   FrameStatus::FocusUnusable, FrameStatus::GeometryUnusable})
    EXPECT_FALSE(recall({}, start + 0.1, status)) << name(status);
}

TEST_F(Memory, WhatIsRecalledLeavesTheMapAlone) {
  see({}, start);
  OccupancyMap map;
  map.update(views.back());
  (void)map.takeChanges();
  for (double t = 0.1; t < 3.0; t += 0.1) {
    ASSERT_TRUE(recall({}, start + t));
    map.update(recalled);
  }
  EXPECT_FALSE(map.takeChanges());
  EXPECT_EQ(map.counters().frames, 1U);
  EXPECT_GT(map.counters().remembered_frames, 20U);
}

TEST_F(Memory, FiltersBeforeItRemembers) {
  MemoryParameters parameters;
  parameters.filter = true;
  memory = ContactMemory(parameters);
  see({}, start);
  EXPECT_TRUE(views.back().contacts.empty()) << "nothing was seen twice yet";
  ASSERT_TRUE(recall({}, start + 0.1));
  EXPECT_TRUE(recalled.contacts.empty());
  see({0.05, 0.0, 0.0}, start + 0.2);
  EXPECT_FALSE(views.back().contacts.empty());
  ASSERT_TRUE(recall({0.05, 0.0, 0.0}, start + 0.3));
  EXPECT_EQ(recalled.contacts.size(), views.back().contacts.size());
}

}  // namespace
}  // namespace ipm_mapping::test
