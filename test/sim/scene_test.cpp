#include <gtest/gtest.h>

#include <filesystem>

#include "ipm_mapping_sim/motion.hpp"
#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ipm_mapping_sim/simulation.hpp"

namespace ipm_mapping::sim {
namespace {

const std::string kScenes = std::string(SOURCE_DIRECTORY) + "/sim/scenes/";

std::string refusal(const std::string& text) {
  try {
    parseScene(text);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Scene, EntriesThatAreUnknownOrOutOfRangeAreRefusedByName) {
  EXPECT_NE(refusal("{name: a, camera: {pich: 0.4}}").find("camera.pich"), std::string::npos);
  EXPECT_NE(refusal("{name: a, camera: {z: -1}}").find("camera.z is -1"), std::string::npos);
  EXPECT_NE(refusal("{name: a, lamps: [{at: [1, 2]}]}").find("lamps[0].at"), std::string::npos);
  EXPECT_NE(refusal("{name: a, obstacles: [{kind: ball}]}").find("box | cylinder"),
            std::string::npos);
  EXPECT_NE(refusal("{seed: 2}").find("name"), std::string::npos);
}

TEST(Scene, OverridesReachIntoMappingsAndLists) {
  const Scene scene =
      parseScene("{name: a, lamps: [{at: [1, 0, 2], size: 1}, {at: [2, 0, 2]}]}",
                 {{"lamps.1.size", "0.5"}, {"camera.pitch_error", "0.01"}, {"seed", "9"}});
  EXPECT_EQ(scene.lamps[1].size, 0.5);
  EXPECT_EQ(scene.lamps[0].size, 1.0);
  EXPECT_EQ(scene.camera.pitch_error, 0.01);
  EXPECT_EQ(scene.seed, 9);
}

TEST(Scene, ItsJsonReadsBackAsTheSameScene) {
  const Scene scene = loadScene(kScenes + "warehouse.yaml");
  const std::string json = sceneJson(scene);
  EXPECT_EQ(sceneJson(parseScene(json)), json);
}

TEST(Scene, ABaseKeepsWhatIsNotChanged) {
  const Scene base = loadScene(kScenes + "lab_normal.yaml");
  const Scene scene = loadScene(kScenes + "level_camera.yaml");
  EXPECT_EQ(scene.name, "level_camera");
  EXPECT_EQ(scene.camera.pitch, 0.0);
  EXPECT_EQ(scene.camera.fx, base.camera.fx);
  EXPECT_EQ(scene.obstacles.size(), base.obstacles.size());
}

TEST(Scene, WhatIsNoObstacleIsNoSolidInTheTruth) {
  const auto truth = [](double height) {
    const std::string box = "{kind: box, name: b, x: 3, h: " + std::to_string(height) + "}";
    return truthJson(Simulation(parseScene("{name: a, obstacles: [" + box + "]}")), 1);
  };
  EXPECT_NE(truth(0.02).find("\"polygon\": [["), std::string::npos);
  EXPECT_EQ(truth(0.01).find("\"polygon\""), std::string::npos);
  const std::string rug = truth(0.01);
  const std::size_t first = rug.find("[[", rug.find("\"polyline\""));
  ASSERT_NE(first, std::string::npos);
  const std::string corner = rug.substr(first + 1, rug.find(']', first) - first);
  EXPECT_EQ(rug.find(corner + "]", first + 2), rug.find("]]", first) + 1 - corner.size());
}

TEST(Scene, TheTruthHasTheWayOfWhatMoves) {
  const std::string truth = truthJson(
      Simulation(parseScene("{name: a, obstacles: [{kind: box, name: b, x: 1.5, way: [{at: 0.5}, "
                            "{at: 2, x: 0.25, y: -1}]}, {kind: box, name: c, x: 3}]}")),
      1);
  const std::size_t footprints = truth.find("\"footprints\"");
  ASSERT_NE(footprints, std::string::npos);
  EXPECT_NE(truth.find("\"way\": [[0.5, 0, 0], [2, 0.25, -1]]}", footprints), std::string::npos);
  const std::size_t other = truth.find("\"name\": \"c\"", footprints);
  ASSERT_NE(other, std::string::npos);
  EXPECT_EQ(truth.find("\"way\"", other), std::string::npos);
}

TEST(Scene, NoScriptedDriveOfAShippedSceneTouchesAnything) {
  int scenes = 0;
  for (const auto& file : std::filesystem::directory_iterator(kScenes)) {
    const Scene scene = loadScene(file.path().string());
    const Drive drive(scene, footprintsOf(makeSolids(scene)));
    EXPECT_LT(drive.collision(), 0.0)
        << scene.name << " at " << drive.collision() << " s, x " << drive.pose(drive.collision()).x;
    EXPECT_EQ(file.path().stem().string(), scene.name);
    ++scenes;
  }
  EXPECT_GE(scenes, 23);
}

}  // namespace
}  // namespace ipm_mapping::sim
