#include "ipm_mapping/ros/stage_messages.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace ipm_mapping {
namespace {

GroundView randomView(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  GroundView view;
  view.camera = CameraModel({640, 480, 500 + u(random), 510 + u(random), 320 + u(random), 239.5},
                            {-0.1 * u(random), 0.02 * u(random), 1e-3 * u(random), 1e-3, 1e-3});
  view.T_base_camera = cameraPose(u(random), u(random), 0.5 + 0.1 * u(random),
                                  0.4 + 0.1 * u(random), 0.3 * u(random), 0.1 * u(random));
  view.T_odom_base = {10 * u(random), 10 * u(random), 3 * u(random)};
  view.motion = {0.1 * u(random), 0.01 * u(random), 0.1 * u(random)};
  view.stamp = 1700000000.25;
  view.reference_stamp = 1700000000.125;
  return view;
}

TEST(StageMessages, GeometrySurvivesBitForBit) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const GroundView view = randomView(random);
    ViewGeometry message;
    toMessage(view, {"base", "odom"}, message);
    GroundView back;
    ASSERT_EQ(fromMessage(message, rosTime(view.stamp), back), std::nullopt);
    EXPECT_TRUE(back.camera == view.camera);
    EXPECT_EQ(back.camera.turningRadiusSquared(), view.camera.turningRadiusSquared());
    EXPECT_EQ(back.T_base_camera.matrix(), view.T_base_camera.matrix());
    EXPECT_EQ(back.T_odom_base.matrix(), view.T_odom_base.matrix());
    EXPECT_EQ(back.motion.matrix(), view.motion.matrix());
    EXPECT_EQ(back.G(), view.G());
    EXPECT_EQ(back.stamp, view.stamp);
    EXPECT_EQ(back.reference_stamp, view.reference_stamp);
  }
}

TEST(StageMessages, GeometryNamesItsFramesAndCarriesBothVanishingPoints) {
  std::mt19937 random(2);
  const GroundView view = randomView(random);
  ViewGeometry message;
  toMessage(view, {"base", "odom"}, message);
  EXPECT_EQ(message.base_frame, "base");
  EXPECT_EQ(message.odom_frame, "odom");
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_EQ(message.vanishing_point_current[at], vanishingPoints(view).f1(i));
    EXPECT_EQ(message.vanishing_point_reference[at], vanishingPoints(view).f2(i));
    EXPECT_EQ(message.homography[3 + at], view.G()(1, i));
  }
}

TEST(StageMessages, ImpossibleGeometryIsRefusedByName) {
  std::mt19937 random(3);
  const auto refusalOf = [&](auto&& change) {
    ViewGeometry message;
    toMessage(randomView(random), {"base", "odom"}, message);
    change(message);
    GroundView view;
    return fromMessage(message, ros::Time(1), view).value_or("accepted");
  };
  using Message = ViewGeometry;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusalOf([](Message& m) { m.K[0] = 0; }).find("K[0]"), std::string::npos);
  EXPECT_NE(refusalOf([&](Message& m) { m.D[1] = nan; }).find("D "), std::string::npos);
  EXPECT_NE(refusalOf([&](Message& m) { m.camera[3] = nan; }).find("view.camera"),
            std::string::npos);
  EXPECT_NE(refusalOf([](Message& m) { m.camera[11] = -0.4; }).find("height"), std::string::npos);
  EXPECT_NE(refusalOf([&](Message& m) { m.pose.x = nan; }).find("view.pose"), std::string::npos);
  EXPECT_NE(refusalOf([&](Message& m) { m.motion.theta = nan; }).find("view.motion"),
            std::string::npos);
}

TEST(StageMessages, StampsSurviveToTheMicrosecondAndNonsenseBecomesZero) {
  EXPECT_NEAR(rosTime(1700000000.123456).toSec(), 1700000000.123456, 1e-6);
  EXPECT_EQ(rosTime(-1.0), ros::Time());
  EXPECT_EQ(rosTime(std::numeric_limits<double>::quiet_NaN()), ros::Time());
  EXPECT_EQ(rosTime(1e300), ros::Time());
}

Obstacles someObstacles() {
  std::mt19937 random(4);
  Obstacles o;
  o.frame = 123456789012ULL;
  o.view = randomView(random);
  o.focus.f = {1.5, 2.5, -0.25};
  o.max_range = 2.0;
  o.age = 1.25F;
  o.separability = 0.75F;
  o.threshold = -1;
  o.bearings = {{0.5F, 0.1F, 1.5F, 0.4F, BearingState::Free},
                {0.25F, 0.2F, 0.9F, 0.4F, BearingState::Occupied},
                {0.0F, 0.3F, 0.4F, 0.4F, BearingState::Blocked},
                {-0.25F, 0.4F, 0.0F, 0.4F, BearingState::Unknown}};
  o.contacts = {{1, 320.5F, 200.25F, {0.9F, 0.1F}, 12.0F, 0.3F, 0.01F, 0.5F, true}};
  o.candidates = {o.contacts[0], {2, 1.0F, 2.0F, {3.0F, 4.0F}, 5.0F, 6.0F, 7.0F, 8.0F}};
  return o;
}

TEST(StageMessages, ObstaclesSurviveWhole) {
  const Obstacles o = someObstacles();
  ObstacleArray message;
  toMessage(o, {"base", "odom"}, message);
  message.header.stamp = rosTime(o.view.stamp);
  EXPECT_EQ(message.header.frame_id, "base");
  Obstacles back;
  back.contacts.resize(17);
  ASSERT_EQ(fromMessage(message, back), std::nullopt);
  EXPECT_EQ(back.frame, o.frame);
  EXPECT_EQ(back.focus.f, o.focus.f);
  EXPECT_EQ(back.max_range, o.max_range);
  EXPECT_EQ(back.age, o.age);
  EXPECT_EQ(back.separability, o.separability);
  EXPECT_EQ(back.threshold, o.threshold);
  ASSERT_EQ(back.bearings.size(), o.bearings.size());
  for (std::size_t i = 0; i < o.bearings.size(); ++i) {
    EXPECT_EQ(back.bearings[i].state, o.bearings[i].state);
    EXPECT_EQ(back.bearings[i].angle, o.bearings[i].angle);
    EXPECT_EQ(back.bearings[i].density, o.bearings[i].density);
    EXPECT_EQ(back.bearings[i].range, o.bearings[i].range);
    EXPECT_EQ(back.bearings[i].near, o.bearings[i].near);
  }
  ASSERT_EQ(back.contacts.size(), 1U);
  ASSERT_EQ(back.candidates.size(), 2U);
  const Contact& c = back.candidates[1];
  EXPECT_EQ(c.bearing, 2);
  EXPECT_EQ(c.u, 1.0F);
  EXPECT_EQ(c.v, 2.0F);
  EXPECT_EQ(c.p_base, Eigen::Vector2f(3, 4));
  EXPECT_EQ(c.score, 5.0F);
  EXPECT_EQ(c.height, 6.0F);
  EXPECT_EQ(c.range_sigma, 7.0F);
  EXPECT_FALSE(c.moving);
  EXPECT_TRUE(back.contacts[0].moving);
  EXPECT_EQ(c.age, 8.0F);
}

TEST(StageMessages, StatesThatDoNotExistAreRefused) {
  ObstacleArray message;
  toMessage(someObstacles(), {"base", "odom"}, message);
  message.bearings[2].state = 4;
  Obstacles back;
  const Refusal refusal = fromMessage(message, back);
  ASSERT_TRUE(refusal);
  EXPECT_NE(refusal->find("state 4"), std::string::npos);
}

TEST(StageMessages, PicturesOfAnotherSizeThanTheirGeometryAreRefused) {
  std::mt19937 random(5);
  DifferenceImage message;
  toMessage(randomView(random), {"base", "odom"}, message.view);
  allocateMono8(640, 480, message.image);
  allocateMono8(640, 480, message.valid);
  GrayView difference, valid;
  ASSERT_EQ(wrap(message, difference, valid), std::nullopt);
  EXPECT_EQ(difference.data, message.image.data.data());
  EXPECT_EQ(valid.data, message.valid.data.data());
  allocateMono8(640, 479, message.valid);
  const Refusal refusal = wrap(message, difference, valid);
  ASSERT_TRUE(refusal);
  EXPECT_NE(refusal->find("640x479"), std::string::npos);
  message.valid.encoding = "32FC1";
  EXPECT_TRUE(wrap(message, difference, valid));
  ObstacleMask mask;
  mask.view = message.view;
  allocateMono8(320, 240, mask.mask);
  EXPECT_TRUE(wrap(mask, valid));
}

}  // namespace
}  // namespace ipm_mapping
