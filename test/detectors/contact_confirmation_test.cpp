#include "ipm_mapping/detectors/contact_confirmation.hpp"

#include <gtest/gtest.h>

#include <random>

namespace ipm_mapping {
namespace {

MemoryParameters filtering() {
  MemoryParameters parameters;
  parameters.filter = true;
  return parameters;
}

/// One contact per point (odom), each on a bearing of its own.
Obstacles answer(const SE2& T_odom_base, const std::vector<Eigen::Vector2d>& points_odom) {
  Obstacles obstacles;
  obstacles.view.T_odom_base = T_odom_base;
  for (const Eigen::Vector2d& p : points_odom) {
    Bearing bearing;
    bearing.state = BearingState::Occupied;
    bearing.range = 1.0F;
    Contact contact;
    contact.bearing = static_cast<int>(obstacles.bearings.size());
    contact.p_base = (T_odom_base.inverse() * p).cast<float>();
    obstacles.bearings.push_back(bearing);
    obstacles.contacts.push_back(contact);
  }
  return obstacles;
}

TEST(ContactConfirmation, OffItLeavesEverything) {
  ContactConfirmation confirmation{MemoryParameters{}};
  Obstacles obstacles = answer({}, {{1.0, 0.0}, {1.5, 0.2}});
  confirmation.apply(obstacles);
  EXPECT_EQ(obstacles.contacts.size(), 2U);
  EXPECT_EQ(obstacles.bearings[0].state, BearingState::Occupied);
}

TEST(ContactConfirmation, ASecondSightFromAnotherPlaceConfirms) {
  ContactConfirmation confirmation{filtering()};
  Obstacles first = answer({}, {{1.0, 0.3}, {1.4, -0.2}});
  confirmation.apply(first);
  EXPECT_TRUE(first.contacts.empty());
  EXPECT_EQ(first.bearings[0].state, BearingState::Unknown);
  Obstacles second = answer({0.1, 0.02, 0.3}, {{1.04, 0.32}, {1.7, -0.2}});
  confirmation.apply(second);
  ASSERT_EQ(second.contacts.size(), 1U);
  EXPECT_EQ(second.contacts[0].bearing, 0);
  EXPECT_EQ(second.bearings[0].state, BearingState::Occupied);
  EXPECT_EQ(second.bearings[1].state, BearingState::Unknown);
}

TEST(ContactConfirmation, WhatMovesIsNotSeenTwiceInOnePlace) {
  ContactConfirmation confirmation{filtering()};
  Obstacles obstacles = answer({}, {{1.0, 0.3}, {1.4, -0.2}});
  obstacles.contacts[1].moving = true;
  confirmation.apply(obstacles);
  ASSERT_EQ(obstacles.contacts.size(), 1U);
  EXPECT_EQ(obstacles.contacts[0].bearing, 1);
  EXPECT_EQ(obstacles.bearings[1].state, BearingState::Occupied);
}

/// What a detector holds it has not seen in this frame.
TEST(ContactConfirmation, WhatIsHeldConfirmsNothing) {
  ContactConfirmation confirmation{filtering()};
  const auto look = [&](float age) {
    Obstacles obstacles = answer({}, {{1.0, 0.3}});
    obstacles.contacts[0].age = age;
    confirmation.apply(obstacles);
    return obstacles.contacts.size();
  };
  EXPECT_EQ(look(0.0F), 0U);
  EXPECT_EQ(look(0.1F), 0U);
  EXPECT_EQ(look(0.0F), 1U);
  EXPECT_EQ(look(0.1F), 1U) << "two of the last four saw it";
  EXPECT_EQ(look(0.2F), 0U) << "one of the last four";
  Obstacles obstacles = answer({}, {{3.0, 0.3}});
  obstacles.contacts[0].age = 0.2F;
  obstacles.bearings[0].state = BearingState::Free;
  confirmation.apply(obstacles);
  EXPECT_TRUE(obstacles.contacts.empty());
  EXPECT_EQ(obstacles.bearings[0].state, BearingState::Free) << "the floor in front of it is";
}

/// A robot that stands sees the same again.
TEST(ContactConfirmation, WhatIsNoNewEvidenceConfirmsNothing) {
  ContactConfirmation confirmation{filtering()};
  const auto look = [&](float age) {
    Obstacles obstacles = answer({}, {{1.0, 0.3}});
    obstacles.age = age;
    confirmation.apply(obstacles);
    return obstacles.contacts.size();
  };
  EXPECT_EQ(look(0.0F), 0U);
  for (int k = 1; k <= 5; ++k) EXPECT_EQ(look(0.1F * static_cast<float>(k)), 0U);
  EXPECT_EQ(look(0.0F), 1U);
  for (int k = 1; k <= 5; ++k) EXPECT_EQ(look(0.1F * static_cast<float>(k)), 1U);
}

TEST(ContactConfirmation, SightsOfOneFrameDoNotConfirmOneAnother) {
  ContactConfirmation confirmation{filtering()};
  Obstacles obstacles = answer({}, {{1.0, 0.0}, {1.0, 0.01}, {1.0, 0.02}});
  confirmation.apply(obstacles);
  EXPECT_TRUE(obstacles.contacts.empty());
}

TEST(ContactConfirmation, AgreesWithCountingOverTheWholeHistory) {
  MemoryParameters parameters = filtering();
  parameters.confirm_frames = 3;
  parameters.confirm_of = 5;
  ContactConfirmation confirmation{parameters};
  std::mt19937 random{5};
  std::uniform_real_distribution<double> place{0.0, 0.5};
  std::vector<std::vector<Eigen::Vector2d>> history;
  int kept = 0, dropped = 0;
  for (int k = 0; k < 60; ++k) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 6; ++i) points.emplace_back(1.0 + place(random), place(random));
    history.push_back(points);
    Obstacles obstacles = answer({0.01 * k, 0.0, 0.02 * k}, points);
    confirmation.apply(obstacles);
    std::vector<int> expected;
    for (int i = 0; i < 6; ++i) {
      int frames = 0;
      for (int back = 0; back < 5 && back <= k; ++back)
        for (const Eigen::Vector2d& p : history[static_cast<std::size_t>(k - back)])
          if ((p - points[static_cast<std::size_t>(i)]).norm() <= parameters.confirm_radius) {
            ++frames;
            break;
          }
      if (frames >= 3) expected.push_back(i);
    }
    ASSERT_EQ(obstacles.contacts.size(), expected.size()) << k;
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(obstacles.contacts[i].bearing, expected[i]);
    kept += static_cast<int>(expected.size());
    dropped += 6 - static_cast<int>(expected.size());
  }
  EXPECT_GT(kept, 15);
  EXPECT_GT(dropped, 15);
}

TEST(ContactConfirmation, AfterClearingNothingIsConfirmedByWhatWasBefore) {
  ContactConfirmation confirmation{filtering()};
  Obstacles obstacles = answer({}, {{1.0, 0.0}});
  confirmation.apply(obstacles);
  confirmation.clear();
  obstacles = answer({}, {{1.0, 0.0}});
  confirmation.apply(obstacles);
  EXPECT_TRUE(obstacles.contacts.empty());
}

}  // namespace
}  // namespace ipm_mapping
