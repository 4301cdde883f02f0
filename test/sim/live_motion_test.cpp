#include "ipm_mapping_sim/live_motion.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ipm_mapping_sim/solids.hpp"

namespace ipm_mapping::sim {
namespace {

Scene testScene() {
  return parseScene(
      "{name: test, drive: [{seconds: 100, v: 0.2}],"
      " obstacles: [{kind: box, name: b, x: 2.0, y: 0, lx: 0.2, ly: 0.5, h: 0.3}]}");
}

TEST(LiveMotion, FollowsTheScriptUntilItIsCommandedAndStopsWhenCommandsStop) {
  const Scene scene = testScene();
  LiveMotion motion(scene, footprintsOf(makeSolids(scene)));
  double t = 0.0;
  for (; t < 2.0; t += 0.02) motion.advance(t);
  EXPECT_NEAR(motion.wheels(t).v, 0.2, 1e-9);
  motion.command({0.0, 0.5});
  for (const double end = t + 0.45; t < end; t += 0.02) motion.advance(t);
  EXPECT_NEAR(motion.wheels(t).w, 0.5, 1e-9);
  EXPECT_NEAR(motion.wheels(t).v, 0.0, 1e-9);
  for (const double end = t + 2.0; t < end; t += 0.02) motion.advance(t);
  EXPECT_NEAR(motion.wheels(t).w, 0.0, 1e-9);
}

TEST(LiveMotion, ThePoseBetweenReadingsIsTheScriptsPoseAtThatTime) {
  Scene scene = testScene();
  LiveMotion motion(scene, {});
  for (int i = 1; i <= 200; ++i) motion.advance(0.02 * i);
  const Drive drive(scene, {});
  for (const double t : {2.113, 2.5, 3.991}) {
    EXPECT_NEAR(motion.pose(t).x, drive.pose(t).x, 2e-3) << t;
  }
}

TEST(LiveMotion, StopsAtTheObstacle) {
  const Scene scene = testScene();
  LiveMotion motion(scene, footprintsOf(makeSolids(scene)));
  double t = 0.0;
  for (; t < 15.0; t += 0.02) motion.advance(t);
  EXPECT_TRUE(motion.touching());
  EXPECT_NEAR(motion.pose(t).x, 1.9 - scene.robot.radius, 0.01);
}

}  // namespace
}  // namespace ipm_mapping::sim
