#include "ipm_mapping_sim/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ipm_mapping_sim/solids.hpp"

namespace ipm_mapping::sim {
namespace {

Drive driveOf(const std::string& more) {
  const Scene scene = parseScene("{name: test, seed: 4, " + more + "}");
  return {scene, footprintsOf(makeSolids(scene))};
}

TEST(Drive, PerfectWheelsReportThePoseThatIsTrue) {
  const Drive drive =
      driveOf("drive: [{seconds: 3, v: 0.3, w: 0.4}, {seconds: 2, v: -0.2, w: 0.1}]");
  for (const OdometryReading& reading : drive.odometry()) {
    const SE2 truth = drive.pose(reading.time);
    EXPECT_NEAR(reading.pose.x, truth.x, 1e-3);
    EXPECT_NEAR(reading.pose.y, truth.y, 1e-3);
    EXPECT_NEAR(reading.pose.theta, truth.theta, 1e-6);
  }
}

TEST(Drive, ACircleIsDrivenAsACircle) {
  // One turn at full speed after the ramp: radius v / w around a fixed centre.
  const Drive drive = driveOf(
      "robot: {acceleration: 100, turn_acceleration: 1000}, drive: [{seconds: 7, v: 0.5, w: 1.0}]");
  for (double t = 0.5; t < 6.5; t += 0.5) {
    const SE2 p = drive.pose(t);
    EXPECT_NEAR(std::hypot(p.x, p.y - 0.5), 0.5, 5e-3) << t;
  }
  EXPECT_NEAR(drive.pose(6.0).theta, 6.0, 0.02);  // and the heading is not wrapped
}

TEST(Drive, ScaleAndBiasAndSlipShowInTheOdometry) {
  const std::string straight = "drive: [{seconds: 10, v: 0.3}]";
  const Drive scaled = driveOf("odometry: {scale: 0.02}, " + straight);
  EXPECT_NEAR(scaled.odometry().back().pose.x / scaled.pose(10.2).x, 1.02, 1e-3);
  const Drive biased = driveOf("odometry: {yaw_bias: 0.01}, " + straight);
  EXPECT_NEAR(biased.odometry().back().pose.theta, 0.01 * 10.4, 3e-3);
  EXPECT_EQ(biased.pose(10.0).theta, 0.0);
  const Drive slipping =
      driveOf("odometry: {slips: [{at: 4, seconds: 2, grip: 0.5}]}, " + straight);
  const double lost = slipping.odometry().back().pose.x - slipping.pose(10.2).x;
  EXPECT_NEAR(lost, 0.5 * 2 * 0.3, 5e-3);
}

TEST(Drive, MessagesAreLostAtTheStatedRate) {
  const Drive drive = driveOf("odometry: {drop_rate: 0.2}, drive: [{seconds: 40, v: 0.1}]");
  double lost = 0;
  for (const OdometryReading& reading : drive.odometry()) lost += !reading.arrives;
  EXPECT_NEAR(lost / static_cast<double>(drive.odometry().size()), 0.2, 0.03);
}

TEST(Body, StopsABodyRadiusBeforeAnObstacleAndMayBackOff) {
  const Scene scene = parseScene(
      "{name: test, obstacles: [{kind: box, name: b, x: 1.15, y: 0, lx: 0.3, ly: 0.3, h: 0.3},"
      " {kind: box, name: plank, x: 0.4, y: 0, lx: 0.1, ly: 0.5, h: 0.02}]}");
  Body body(scene.robot, footprintsOf(makeSolids(scene)));
  for (int i = 0; i < 2000; ++i) body.step({0.3, 0.0}, {0, 0, 1, 1}, 0.0, 0.005);
  EXPECT_TRUE(body.touching());
  EXPECT_NEAR(body.pose().x, 1.0 - scene.robot.radius, 0.01);
  for (int i = 0; i < 200; ++i) body.step({-0.3, 0.0}, {0, 0, 1, 1}, 0.0, 0.005);
  EXPECT_FALSE(body.touching());
  EXPECT_LT(body.pose().x, 0.75);
}

TEST(Body, StopsForSomebodyWhoIsThereAtTheTime) {
  const Scene scene = parseScene(
      "{name: test, obstacles: [{kind: cylinder, name: c, x: 0.6, y: 2, r: 0.1, h: 0.5,"
      " way: [{at: 1, x: 0, y: 0}, {at: 3, x: 0, y: -2}]}]}");
  const auto stops = [&](double time) {
    Body body(scene.robot, footprintsOf(makeSolids(scene)));
    for (int i = 0; i < 1000; ++i) body.step({0.3, 0.0}, {0, 0, 1, 1}, time, 0.005);
    return body.touching();
  };
  EXPECT_FALSE(stops(0.0));
  EXPECT_FALSE(stops(2.0)) << "still a metre beside the way";
  EXPECT_TRUE(stops(3.0));
  EXPECT_TRUE(stops(10.0)) << "it stays where its way ends";
}

TEST(Ways, LeadStraightFromPointToPointAndRestBeforeAndAfter) {
  const std::vector<Waypoint> way{{1.0, 0.5, 0.0}, {2.0, 0.5, 1.0}, {4.0, -1.5, 1.0}};
  EXPECT_EQ(goneAlong(way, 0.0), Point(0.5, 0.0));
  EXPECT_EQ(goneAlong(way, 1.0), Point(0.5, 0.0));
  EXPECT_EQ(goneAlong(way, 1.25), Point(0.5, 0.25));
  EXPECT_EQ(goneAlong(way, 2.0), Point(0.5, 1.0));
  EXPECT_EQ(goneAlong(way, 3.0), Point(-0.5, 1.0));
  EXPECT_EQ(goneAlong(way, 9.0), Point(-1.5, 1.0));
  EXPECT_EQ(goneAlong({}, 3.0), Point(0.0, 0.0));
}

TEST(Ways, HaveToGoForwardInTime) {
  const auto solids = [](const std::string& times) {
    return makeSolids(
        parseScene("{name: test, obstacles: [{kind: box, name: cart, way: [" + times + "]}]}"));
  };
  EXPECT_NO_THROW(solids("{at: 1}, {at: 2}"));
  try {
    solids("{at: 2}, {at: 2}");
    FAIL() << "two places at once";
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("cart"), std::string::npos);
  }
}

TEST(Solids, WhatHangsTouchesNoFloorAndIsClosedBelow) {
  const Scene scene = parseScene(
      "{name: test, obstacles: [{kind: cylinder, name: lamp, x: 1, y: 0, z: 0.5, r: 0.2, h: 0.3},"
      " {kind: cylinder, name: bin, x: 2, y: 0, r: 0.2, h: 0.3}]}");
  const std::vector<Solid> solids = makeSolids(scene);
  EXPECT_TRUE(solids[0].footprints.empty());
  EXPECT_EQ(solids[1].footprints.size(), 1U);
  EXPECT_EQ(solids[0].patches.size(), solids[1].patches.size() + 1);
  const Patch& below = solids[0].patches.back();
  for (const Eigen::Vector3f& p : below.points) EXPECT_FLOAT_EQ(p.z(), 0.5F);
  float down = 0.0F;
  for (int prim = 0; prim < below.triangleCount(); ++prim) {
    const Eigen::Vector3i corners = below.triangle(prim);
    const auto at = [&](int k) { return below.points[static_cast<std::size_t>(corners[k])]; };
    const float twice = (at(1) - at(0)).cross(at(2) - at(0)).z();
    EXPECT_LE(twice, 1e-9F);
    down -= 0.5F * twice;
  }
  EXPECT_NEAR(down, M_PI * 0.2 * 0.2, 0.002);
}

TEST(Footprints, DistanceIsZeroInsideAndEuclideanOutside) {
  const Footprint square{"s", "box", 1.0, true, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  EXPECT_EQ(distanceTo(square, {0.5, 0.5}, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(distanceTo(square, {2.0, 0.5}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(distanceTo(square, {4.0, 5.0}, 0.0), 5.0);
  const Footprint line{"l", "cable", 0.01, false, {{0, 0}, {1, 0}, {1, 1}}};
  EXPECT_DOUBLE_EQ(distanceTo(line, {0.5, 0.5}, 0.0), 0.5);
}

TEST(Solids, WhatTouchesTheFloorIsInTheFootprints) {
  const Scene scene = loadScene(std::string(SOURCE_DIRECTORY) + "/sim/scenes/living_room.yaml");
  for (const Solid& solid : makeSolids(scene)) {
    for (const Patch& patch : solid.patches) {
      for (const Eigen::Vector3f& p : patch.points) {
        if (p.z() > 1e-4F) continue;
        double nearest = 1e9;
        for (const Footprint& footprint : solid.footprints) {
          nearest = std::min(nearest, distanceTo(footprint, p.head<2>().cast<double>(), 0.0));
        }
        EXPECT_LT(nearest, 1e-4) << solid.footprints[0].name;
      }
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::sim
