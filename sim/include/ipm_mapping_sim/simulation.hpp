#pragma once
// One scene from its first to its last frame.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ipm_mapping_sim/motion.hpp"
#include "ipm_mapping_sim/renderer.hpp"
#include "ipm_mapping_sim/sensor.hpp"

namespace ipm_mapping::sim {

/// True pose of the robot at a time, and how fast its wheels turn.
struct Moving {
  std::function<SE2(double)> pose;
  std::function<Command(double)> wheels;
};

/// The camera: shakes with the robot, exposes rows one after the other, blurs what moves.
class SimulatedCamera {
 public:
  explicit SimulatedCamera(const Scene& scene);

  /// Grey levels of frame number `frame`, whose middle row is exposed around `time`.
  void capture(int frame, double time, const Moving& robot, std::vector<std::uint8_t>& grey);
  [[nodiscard]] const Stage& stage() const { return renderer_.stage(); }

 private:
  [[nodiscard]] CameraPose cameraAt(double time, const Moving& robot) const;

  Scene scene_;
  Renderer renderer_;
  Sensor sensor_;
  std::vector<float> radiance_, sum_;
};

/// A scene's scripted drive.
class Simulation {
 public:
  explicit Simulation(const Scene& scene);

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const Drive& drive() const { return drive_; }
  [[nodiscard]] const Stage& stage() const { return camera_.stage(); }
  [[nodiscard]] int frameCount() const;
  [[nodiscard]] double frameTime(int frame) const { return frame / scene_.rate; }
  /// False for the frames that the scene loses.
  [[nodiscard]] bool arrives(int frame) const;
  void capture(int frame, std::vector<std::uint8_t>& grey);

 private:
  Scene scene_;
  SimulatedCamera camera_;
  Drive drive_;
};

/// The truth about the first `frames` frames as JSON: the scene, the floor outlines of what stands
/// there, the true pose of each frame, the camera's place on the robot and the first frame's stamp.
std::string truthJson(const Simulation& simulation, int frames);

}  // namespace ipm_mapping::sim
