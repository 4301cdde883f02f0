#include "ipm_mapping/ros/bag_arguments.hpp"

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "ipm_mapping/io/parameters_yaml.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

/// What `--set camera/NAME=VALUE` would refuse is refused here as well.
void requireSensible(const std::array<double, 4>& pose) {
  CameraParameters stated;
  stated.x = pose[0];
  stated.y = pose[1];
  stated.z = pose[2];
  stated.pitch = pose[3];
  validateFields("--camera-pose: camera", stated);
}

bool partOfPose(const std::string& name) {
  return name == "camera/x" || name == "camera/y" || name == "camera/z" || name == "camera/pitch" ||
         name == "camera/yaw" || name == "camera/roll";
}

}  // namespace

void BagArguments::declare(CLI::App& app) {
  app.add_option("--profile", profile, "default, paper, first_architecture, or a YAML file");
  app.add_option("--set", settings, "one parameter: GROUP/NAME=VALUE; may be repeated");
  app.add_option("--image-topic", options.topics.image, "default: found by name and type");
  app.add_option("--camera-info-topic", options.topics.camera_info, "default: beside the images");
  app.add_option("--odom-topic", options.topics.odometry, "default: found by name and type");
  app.add_option("--camera-info", options.calibration_file,
                 "calibration as YAML, instead of the bag's");
  app.add_option("--camera-pose", camera_pose,
                 "x,y,z,pitch of the camera on the robot (m, rad), instead of tf's")
      ->delimiter(',')
      ->expected(4);
}

void BagArguments::settle() {
  options.parameters = profileOrFile(profile);
  for (const std::string& setting : settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos)
      throw ParameterError("--set " + setting + ": write GROUP/NAME=VALUE");
    const std::string name = setting.substr(0, equals);
    options.parameters.set(name, setting.substr(equals + 1));
    if (partOfPose(name)) options.pose_settings.push_back(name);
  }
  options.parameters.validate();
  if (camera_pose.empty()) return;
  options.camera_pose = {camera_pose[0], camera_pose[1], camera_pose[2], camera_pose[3]};
  requireSensible(*options.camera_pose);
}

CLI::Validator positiveNumber() {
  return {[](const std::string& text) {
            const double value = std::strtod(text.c_str(), nullptr);
            return value > 0.0 && std::isfinite(value)
                       ? std::string()
                       : "has to be a number above 0, not '" + text + "'";
          },
          "POSITIVE"};
}

void printWarning(std::ostream& out, const std::string& words) {
  if (!words.empty()) out << "warning: " << words << '\n';
}

int runTool(CLI::App& app, const char* name, int argc, char** argv,
            const std::function<void()>& settle, const std::function<void()>& work) {
  try {
    app.parse(argc, argv);
    settle();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : exit_usage;
  } catch (const ParameterError& error) {
    std::cerr << name << ": " << error.what() << '\n';
    return exit_usage;
  }
  try {
    work();
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << '\n';
    return exit_input;
  }
  return 0;
}

}  // namespace ipm_mapping
