#include "ipm_mapping_sim/simulation.hpp"

#include <cmath>
#include <sstream>

#include "ipm_mapping_sim/scene_yaml.hpp"

namespace ipm_mapping::sim {
namespace {

constexpr double kShakeSpeed = 0.3;  // m/s at which a shake reaches its stated amplitude

CameraPose worldPose(const SE2& base) {
  CameraPose pose = CameraPose::Identity();
  pose.linear() = Eigen::AngleAxisd(base.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(base.x, base.y, 0.0);
  return pose;
}

void writeVector(std::ostream& out, const Eigen::Vector3d& v) {
  out << "[" << v.x() << ", " << v.y() << ", " << v.z() << "]";
}

/// What is too low to be an obstacle is written as a line: nobody collides with a rug.
void writeFootprint(std::ostream& out, const Footprint& footprint) {
  std::vector<Point> points = footprint.points;
  const bool solid = footprint.closed && footprint.height >= kObstacleHeight;
  if (footprint.closed && !solid) points.push_back(points.front());
  out << "{\"name\": \"" << footprint.name << "\", \"kind\": \"" << footprint.kind
      << "\", \"height\": " << footprint.height << ", \"" << (solid ? "polygon" : "polyline")
      << "\": [";
  for (std::size_t i = 0; i < points.size(); ++i) {
    out << (i == 0 ? "[" : ", [") << points[i].x() << ", " << points[i].y() << "]";
  }
  out << "]";
  for (std::size_t i = 0; i < footprint.way.size(); ++i) {
    const Waypoint& w = footprint.way[i];
    out << (i == 0 ? ", \"way\": [[" : ", [") << w.at << ", " << w.x << ", " << w.y << "]";
  }
  out << (footprint.way.empty() ? "}" : "]}");
}

}  // namespace

SimulatedCamera::SimulatedCamera(const Scene& scene)
    : scene_(scene),
      renderer_(scene_),
      sensor_(scene_.sensor, scene_.camera.width, scene_.camera.height,
              static_cast<std::uint64_t>(scene_.seed)) {}

CameraPose SimulatedCamera::cameraAt(double time, const Moving& robot) const {
  const SensorSpec& sensor = scene_.sensor;
  CameraSpec camera = scene_.camera;
  if (sensor.shake > 0.0) {
    const double turn = 2.0 * M_PI * sensor.shake_rate * time;
    const double wave = 0.7 * std::sin(turn) + 0.3 * std::sin(1.73 * turn + 1.0);
    camera.pitch_error += sensor.shake * wave * std::abs(robot.wheels(time).v) / kShakeSpeed;
  }
  return worldPose(robot.pose(time)) * truePose(camera);
}

void SimulatedCamera::capture(int frame, double time, const Moving& robot,
                              std::vector<std::uint8_t>& grey) {
  const SensorSpec& sensor = scene_.sensor;
  const int samples = sensor.exposure_time > 0.0 ? sensor.blur_samples : 1;
  const int height = scene_.camera.height;
  for (int k = 0; k < samples; ++k) {
    const double instant = time + ((k + 0.5) / samples - 0.5) * sensor.exposure_time;
    const auto row_pose = [&](int row) {
      return cameraAt(
          instant + (static_cast<double>(row) / (height - 1) - 0.5) * sensor.readout_time, robot);
    };
    renderer_.moveTo(instant);
    renderer_.render(row_pose, radiance_);
    if (k == 0) sum_.assign(radiance_.size(), 0.0F);
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      sum_[i] += radiance_[i] / static_cast<float>(samples);
    }
  }
  sensor_.expose(frame, time, sum_, grey);
}

Simulation::Simulation(const Scene& scene)
    : scene_(scene), camera_(scene_), drive_(scene_, camera_.stage().footprints()) {}

int Simulation::frameCount() const {
  return static_cast<int>(std::floor(drive_.duration() * scene_.rate + 1e-9)) + 1;
}

bool Simulation::arrives(int frame) const {
  const auto bits =
      hashOf(static_cast<std::uint64_t>(scene_.seed),
             static_cast<std::uint64_t>(Stream::Drop) ^ 0x1000, static_cast<std::uint64_t>(frame));
  return static_cast<double>(unitFloat(bits)) >= scene_.sensor.drop_rate;
}

void Simulation::capture(int frame, std::vector<std::uint8_t>& grey) {
  const Moving robot{[this](double t) { return drive_.pose(t); },
                     [this](double t) { return drive_.wheels(t); }};
  camera_.capture(frame, frameTime(frame), robot, grey);
}

std::string truthJson(const Simulation& simulation, int frames) {
  std::ostringstream out;
  out.precision(12);
  out << "{\"scene\": " << sceneJson(simulation.scene()) << ", \"poses\": [";
  for (int k = 0; k < frames; ++k) {
    const double t = simulation.frameTime(k);
    const SE2 pose = simulation.drive().pose(t);
    out << (k == 0 ? "[" : ", [") << t << ", " << pose.x << ", " << pose.y << ", " << pose.theta
        << "]";
  }
  out << "], \"footprints\": [";
  const auto& footprints = simulation.stage().footprints();
  for (std::size_t i = 0; i < footprints.size(); ++i) {
    if (i > 0) out << ", ";
    writeFootprint(out, footprints[i]);
  }
  const CameraPose pose = truePose(simulation.scene().camera);
  out << "], \"camera_in_robot\": {\"translation\": ";
  writeVector(out, pose.translation());
  const char* axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    out << (k == 0 ? ", \"optical_axes\": {\"" : ", \"") << axes[k] << "\": ";
    writeVector(out, pose.linear().col(k));
  }
  out << "}}, \"bag_start\": " << simulation.scene().start_stamp << "}\n";
  return out.str();
}

}  // namespace ipm_mapping::sim
