// Golden vectors for a hardware test bench: the inputs and every wire of one frame, taken from a
// bag or from files. Exit codes: 0 done, 2 wrong usage, 3 input unreadable or missing.

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <optional>

#include "ipm_mapping/detectors/fpga_detector.hpp"
#include "ipm_mapping/fpga/vectors.hpp"
#include "ipm_mapping/io/parameters_yaml.hpp"
#include "ipm_mapping/ros/offline_run.hpp"

namespace {

using namespace ipm_mapping;

constexpr int exit_usage = 2;
constexpr int exit_input = 3;

struct Arguments {
  OfflineOptions options;
  std::string inputs;
  std::string out;
  std::string profile = "default";
  std::vector<std::string> settings;
  std::vector<double> camera_pose;
  std::int64_t frame = -1;
};

void declare(CLI::App& app, Arguments& a) {
  app.add_option("bag", a.options.bag, "recording with images and odometry");
  app.add_option("--frame", a.frame, "index of the image in the bag, from 0");
  app.add_option("--inputs", a.inputs,
                 "folder with reference.pgm, current.pgm and params.txt, instead of a bag");
  app.add_option("--out", a.out, "folder for the vectors (made if missing)")->required();
  app.add_option("--profile", a.profile, "default, paper, or a YAML file");
  app.add_option("--set", a.settings, "one parameter: GROUP/NAME=VALUE; may be repeated");
  app.add_option("--image-topic", a.options.topics.image, "default: found by name and type");
  app.add_option("--camera-info-topic", a.options.topics.camera_info, "default: beside the images");
  app.add_option("--odom-topic", a.options.topics.odometry, "default: found by name and type");
  app.add_option("--camera-info", a.options.calibration_file,
                 "calibration as YAML, instead of the bag's");
  app.add_option("--camera-pose", a.camera_pose,
                 "x,y,z,pitch of the camera on the robot (m, rad), instead of tf's")
      ->delimiter(',')
      ->expected(4);
}

void settle(Arguments& a) {
  const bool from_bag = !a.options.bag.empty();
  if (from_bag == !a.inputs.empty()) throw ParameterError("give either a bag or --inputs DIR");
  if (from_bag && a.frame < 0) throw ParameterError("--frame N: say which image of the bag");
  a.options.parameters = profileOrFile(a.profile);
  for (const std::string& setting : a.settings) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos)
      throw ParameterError("--set " + setting + ": write GROUP/NAME=VALUE");
    a.options.parameters.set(setting.substr(0, equals), setting.substr(equals + 1));
  }
  a.options.parameters.validate();
  if (!a.camera_pose.empty())
    a.options.camera_pose = {a.camera_pose[0], a.camera_pose[1], a.camera_pose[2],
                             a.camera_pose[3]};
}

SE2 poseOf(const nav_msgs::Odometry& odometry) {
  const auto& p = odometry.pose.pose.position;
  const auto& q = odometry.pose.pose.orientation;
  return {p.x, p.y, std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))};
}

/// Runs the model over the bag, with its history and its threshold register, up to one frame.
class FrameDumper {
 public:
  explicit FrameDumper(const Arguments& a)
      : a_(a), detector_(a.options.parameters), gate_(a.options.parameters.odometry) {}

  void run() {
    const BagSource bag(a_.options.bag, a_.options.topics);
    const RunCamera camera = resolveCamera(bag, a_.options);
    detector_.setCamera(camera.model, camera.T_base_camera);
    if (detector_.cameraError()) throw BagError(*detector_.cameraError());
    bag.read({[this](const BagSource::Image& image) { addImage(image); },
              [this](double stamp, double arrival, const nav_msgs::Odometry& odometry) {
                if (gate_.addOdometry(stamp, poseOf(odometry), arrival)) detector_.reset();
                processReady();
              },
              [](double) {}});
    if (!reached_)
      throw BagError("frame " + std::to_string(a_.frame) + " is not in the bag, or has no pose (" +
                     std::to_string(next_index_) + " images)");
  }

 private:
  using Payload = std::pair<std::int64_t, GrayPicture>;

  void addImage(const BagSource::Image& image) {
    const std::int64_t index = next_index_++;
    if (!image.picture) return;
    const double stamp = image.stamp + a_.options.parameters.camera.image_time_offset;
    if (gate_.addFrame(stamp, {index, *image.picture}, image.arrival)) detector_.reset();
    processReady();
  }

  void processReady() {
    FrameGate<Payload>::Released frame;
    while (!reached_ && gate_.next(frame)) {
      const auto& [index, picture] = frame.payload;
      const FrameStatus status = detector_.process(
          {static_cast<std::uint64_t>(index), frame.stamp, picture.view, frame.T_odom_base},
          obstacles_);
      if (index == a_.frame) dump(status, picture.view);
    }
  }

  void dump(FrameStatus status, GrayView current) {
    reached_ = true;
    if (status != FrameStatus::Used)
      throw BagError("frame " + std::to_string(a_.frame) + " was skipped: " + name(status));
    fpga::dumpVectors({detector_.reference(), current, detector_.frameSetup().parameters}, a_.out);
  }

  const Arguments& a_;
  FpgaDetector detector_;
  FrameGate<Payload> gate_;
  Obstacles obstacles_;
  std::int64_t next_index_ = 0;
  bool reached_ = false;
};

void dump(const Arguments& a) {
  if (a.inputs.empty()) {
    FrameDumper(a).run();
  } else {
    const fpga::OwnedInputs owned = fpga::readInputs(a.inputs);
    fpga::dumpVectors(owned.inputs(), a.out);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Writes one frame's inputs and every wire of the FPGA model"};
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
    settle(arguments);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : exit_usage;
  } catch (const ParameterError& error) {
    std::cerr << "dump_vectors: " << error.what() << '\n';
    return exit_usage;
  }
  try {
    dump(arguments);
  } catch (const std::exception& error) {
    std::cerr << "dump_vectors: " << error.what() << '\n';
    return exit_input;
  }
  return 0;
}
