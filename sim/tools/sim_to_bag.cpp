// Renders a scene's scripted drive into a bag and writes the truth beside it.

#include <ros/datatypes.h>
#include <ros/message_traits.h>
#include <rosbag/bag.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ros/help.hpp"
#include "ros/messages.hpp"

namespace {

using namespace ipm_mapping::sim;

constexpr const char* kUsage =
    "usage: sim_to_bag SCENE.yaml OUT.bag [--seed N] [--frames N] [--truth OUT.truth.json]\n"
    "                  [--set PATH=VALUE ...]   e.g. --set camera.pitch_error=0.01\n"
    "--frames takes the first N frames of the drive; without it, all of them\n";

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Options {
  std::string scene, bag, truth;
  std::optional<int> frames;
  std::vector<Override> overrides;
};

int wholeNumber(const std::string& option, const std::string& text) {
  std::size_t used = 0;
  int value = -1;
  try {
    value = std::stoi(text, &used);
  } catch (const std::exception&) {
  }
  if (used == 0 || used != text.size() || value < 0) {
    throw UsageError(option + " needs a whole number, not '" + text + "'");
  }
  return value;
}

void takeOption(const std::string& option, const std::string& value, Options& options) {
  if (option == "--seed") {
    options.overrides.emplace_back("seed", std::to_string(wholeNumber(option, value)));
  } else if (option == "--frames") {
    options.frames = wholeNumber(option, value);
    if (*options.frames == 0) throw UsageError("--frames 0 leaves nothing to write");
  } else if (option == "--truth") {
    options.truth = value;
  } else if (option == "--set") {
    const std::size_t equals = value.find('=');
    if (equals == std::string::npos) throw UsageError("--set needs PATH=VALUE, not " + value);
    options.overrides.emplace_back(value.substr(0, equals), value.substr(equals + 1));
  } else {
    throw UsageError("unknown option " + option);
  }
}

Options parse(const std::vector<std::string>& arguments) {
  Options options;
  std::vector<std::string> files;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].rfind("--", 0) != 0) {
      files.push_back(arguments[i]);
      continue;
    }
    if (i + 1 == arguments.size()) throw UsageError(arguments[i] + " needs a value");
    takeOption(arguments[i], arguments[i + 1], options);
    ++i;
  }
  if (files.size() != 2) throw UsageError("a scene and a bag are needed");
  options.scene = files[0];
  options.bag = files[1];
  if (options.truth.empty()) {
    const std::size_t dot = options.bag.rfind(".bag");
    options.truth = options.bag.substr(0, dot) + ".truth.json";
  }
  return options;
}

/// Header of a latched topic, as rosbag record keeps it: players that start in the middle of the
/// bag publish its last message first.
template <class Message>
boost::shared_ptr<ros::M_string> latched() {
  namespace traits = ros::message_traits;
  return boost::make_shared<ros::M_string>(
      ros::M_string{{"type", traits::datatype<Message>()},
                    {"md5sum", traits::md5sum<Message>()},
                    {"message_definition", traits::definition<Message>()},
                    {"latching", "1"}});
}

/// Writes messages in the order in which they arrive.
class Recorder {
 public:
  Recorder(const Simulation& simulation, const std::string& path)
      : simulation_(simulation), scene_(simulation.scene()), bag_(path, rosbag::bagmode::Write) {
    const ros::Time start = arrival(-Drive::kLead);
    tf2_msgs::TFMessage fixed;
    fixed.transforms.push_back(cameraTransform(scene_, stampOf(scene_, 0.0)));
    bag_.write("/tf_static", start, fixed, latched<tf2_msgs::TFMessage>());
  }

  /// Odometry that arrives before `time`.
  void writeOdometry(double time) {
    const auto& readings = simulation_.drive().odometry();
    const double delay = scene_.odometry.arrival_delay;
    for (; next_ < readings.size() && readings[next_].time + delay < time; ++next_) {
      const OdometryReading& reading = readings[next_];
      if (!reading.arrives) continue;
      const nav_msgs::Odometry odometry =
          odometryMessage(reading.pose, reading.speed, stampOf(scene_, reading.time), kOdomFrame);
      tf2_msgs::TFMessage transforms;
      transforms.transforms.push_back(transformOf(odometry));
      bag_.write("/odom", arrival(reading.time + delay), odometry);
      bag_.write("/tf", arrival(reading.time + delay), transforms);
    }
  }

  void writeFrame(int frame, std::vector<std::uint8_t>&& grey) {
    const SensorSpec& sensor = scene_.sensor;
    const double time = simulation_.frameTime(frame), stamped = time + sensor.stamp_error;
    const double at = std::max(time, stamped) + sensor.arrival_delay;
    writeOdometry(at);
    const ros::Time stamp = stampOf(scene_, stamped);
    bag_.write("/camera/rgb/camera_info", arrival(at), cameraInfoMessage(scene_, stamp));
    bag_.write("/camera/rgb/image_raw", arrival(at), imageMessage(scene_, stamp, std::move(grey)));
  }

 private:
  [[nodiscard]] ros::Time arrival(double time) const { return stampOf(scene_, time); }

  const Simulation& simulation_;
  const Scene& scene_;
  rosbag::Bag bag_;
  std::size_t next_ = 0;
};

void run(const Options& options) {
  const Scene scene = loadScene(options.scene, options.overrides);
  Simulation simulation(scene);
  const int frames =
      std::min(options.frames.value_or(simulation.frameCount()), simulation.frameCount());
  const double end = simulation.frameTime(std::max(frames - 1, 0));
  const double collision = simulation.drive().collision();
  if (collision >= 0.0 && collision <= end) {
    std::cerr << "sim_to_bag: the drive of " << scene.name << " touches an obstacle at "
              << collision << " s and stops there\n";
  }
  Recorder recorder(simulation, options.bag);
  std::vector<std::uint8_t> grey;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const std::clock_t start = std::clock();
  for (int frame = 0; frame < frames; ++frame) {
    if (terminal) std::fprintf(stderr, "\rframe %d of %d", frame + 1, frames);
    if (!simulation.arrives(frame)) continue;
    simulation.capture(frame, grey);
    recorder.writeFrame(frame, std::move(grey));
  }
  if (terminal) std::fprintf(stderr, "\n");
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%d frames, %.1f a second of one core\n", frames, frames / std::max(seconds, 1e-6));
  recorder.writeOdometry(end + Drive::kLead);
  std::ofstream truth(options.truth);
  truth << truthJson(simulation, frames);
  if (!truth.flush()) throw std::runtime_error("cannot write " + options.truth);
}

}  // namespace

int main(int argc, char** argv) {
  if (asksForHelp(argc, argv)) {
    std::cout << kUsage;
    return 0;
  }
  try {
    ros::Time::init();
    run(parse({argv + 1, argv + argc}));
    return 0;
  } catch (const UsageError& error) {
    std::cerr << "sim_to_bag: " << error.what() << "\n" << kUsage;
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "sim_to_bag: " << error.what() << "\n";
    return 3;
  }
}
