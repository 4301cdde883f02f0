// What the fraction bits of one wire do to pixels, mask, contacts and map of a drive.
// Exit codes: 0 done, 2 wrong usage, 3 input unreadable or missing.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "ipm_mapping/detectors/fpga_detector.hpp"
#include "ipm_mapping/detectors/word_length_study.hpp"
#include "ipm_mapping/io/atomic_file.hpp"
#include "ipm_mapping/io/parameters_yaml.hpp"
#include "ipm_mapping/ros/offline_run.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace {

using namespace ipm_mapping;

constexpr int exit_usage = 2;
constexpr int exit_input = 3;

struct Arguments {
  OfflineOptions options;
  std::string out;
  std::string profile = "default";
  std::string wire = "homography_linear";
  std::string bits = "4..16";
  std::size_t pairs = 8;
  std::vector<std::string> settings;
  std::vector<double> camera_pose;
  int first = 0, last = 0;
};

std::string wireNames() {
  std::string names;
  for (const char* each : fpga::explored_wire_names)
    names += (names.empty() ? "" : ", ") + std::string(each);
  return names;
}

void declare(CLI::App& app, Arguments& a) {
  app.add_option("bag", a.options.bag, "recording with images and odometry")->required();
  app.add_option("--wire", a.wire, wireNames());
  app.add_option("--bits", a.bits, "fraction bits to try: A..B, or one number");
  app.add_option("--pairs", a.pairs, "frame pairs, spread over the bag: so many to twice as many")
      ->check(CLI::Range(1, 1000));
  app.add_option("--out", a.out, "folder for the tables (made if missing)")->required();
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

void readBits(Arguments& a) {
  char rest = 0;
  const int read = std::sscanf(a.bits.c_str(), "%d..%d%c", &a.first, &a.last, &rest);
  if (read == 1 && std::to_string(a.first) == a.bits) {
    a.last = a.first;
  } else if (read != 2) {
    throw ParameterError("--bits " + a.bits + ": write A..B");
  }
  if (a.first < 0 || a.last < a.first || a.last > fpga::WordLengths::longest)
    throw ParameterError("--bits " + a.bits +
                         ": 0 <= A <= B <= " + std::to_string(fpga::WordLengths::longest));
}

void settle(Arguments& a) {
  readBits(a);
  if (!fpga::exploredWire(a.wire))
    throw ParameterError("--wire " + a.wire + " is not known; there are: " + wireNames());
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

/// A frame pair that owns its pictures.
struct OwnedPair {
  std::uint64_t frame = 0;
  GroundView view;
  Image<std::uint8_t> reference, current;
  std::uint8_t threshold_in = 0;

  [[nodiscard]] fpga::ExplorerInput input() const {
    return {view, reference.view(), current.view(), threshold_in};
  }
};

void copy(GrayView from, Image<std::uint8_t>& to) {
  to.ensure(from.width, from.height);
  for (int v = 0; v < from.height; ++v) std::copy_n(from.row(v), from.width, to.row(v));
}

/// Pairs spread evenly over a bag whose length is not known: when twice as many as wanted are kept,
/// every other one goes, and from then on only half as many are taken.
class SpreadPairs {
 public:
  explicit SpreadPairs(std::size_t wanted) : wanted_(wanted) {}

  void offer(const FpgaDetector& detector, const Obstacles& obstacles, GrayView current) {
    if (offered_++ % stride_ != 0) return;
    OwnedPair& pair = pairs_.emplace_back();
    pair.frame = obstacles.frame;
    pair.view = obstacles.view;
    pair.threshold_in = static_cast<std::uint8_t>(detector.frameSetup().parameters.threshold_in);
    copy(detector.reference(), pair.reference);
    copy(current, pair.current);
    if (pairs_.size() >= 2 * wanted_) thin();
  }
  [[nodiscard]] const std::vector<OwnedPair>& pairs() const { return pairs_; }

 private:
  void thin() {
    for (std::size_t i = 0; 2 * i < pairs_.size(); ++i) std::swap(pairs_[i], pairs_[2 * i]);
    pairs_.resize((pairs_.size() + 1) / 2);
    stride_ *= 2;
  }

  std::size_t wanted_, stride_ = 1, offered_ = 0;
  std::vector<OwnedPair> pairs_;
};

/// Runs the model over the bag, as the hardware would see it, and keeps some of its frame pairs.
class PairReader {
 public:
  explicit PairReader(const Arguments& a)
      : a_(a),
        detector_(a.options.parameters),
        gate_(a.options.parameters.odometry),
        kept_(a.pairs) {}

  const std::vector<OwnedPair>& read() {
    const BagSource bag(a_.options.bag, a_.options.topics);
    const RunCamera camera = resolveCamera(bag, a_.options);
    detector_.setCamera(camera.model, camera.T_base_camera);
    if (detector_.cameraError()) throw BagError(*detector_.cameraError());
    bag.read({[this](const BagSource::Image& image) { addImage(image); },
              [this](double stamp, const nav_msgs::Odometry& odometry) {
                if (gate_.addOdometry(stamp, toSE2(odometry.pose.pose))) detector_.reset();
                processReady();
              },
              [](double) {}});
    if (kept_.pairs().empty()) throw BagError("no frame of the bag could be used");
    return kept_.pairs();
  }

 private:
  using Payload = std::pair<std::uint64_t, GrayPicture>;

  void addImage(const BagSource::Image& image) {
    const std::uint64_t index = next_index_++;
    if (!image.picture) return;
    const double stamp = image.stamp + a_.options.parameters.camera.image_time_offset;
    if (gate_.addFrame(stamp, {index, *image.picture})) detector_.reset();
    processReady();
  }

  void processReady() {
    FrameGate<Payload>::Released frame;
    while (gate_.next(frame)) {
      const auto& [index, picture] = frame.payload;
      const Frame input{index, frame.stamp, picture.view, frame.T_odom_base};
      if (detector_.process(input, obstacles_) == FrameStatus::Used)
        kept_.offer(detector_, obstacles_, picture.view);
    }
  }

  const Arguments& a_;
  FpgaDetector detector_;
  FrameGate<Payload> gate_;
  SpreadPairs kept_;
  Obstacles obstacles_;
  std::uint64_t next_index_ = 0;
};

void write(const std::string& path, const std::string& text) {
  if (const auto error = writeFileAtomically(path, text)) throw std::runtime_error(*error);
}

void explore(const Arguments& a) {
  PairReader reader(a);
  WordLengthStudy study(a.options.parameters, *fpga::exploredWire(a.wire), a.first, a.last);
  std::filesystem::create_directories(a.out);
  for (const OwnedPair& pair : reader.read()) {
    const auto results = study.add(pair.input());
    write(a.out + "/" + a.wire + "_frame_" + std::to_string(pair.frame) + ".csv",
          fpga::wordLengthCsv(study.wire(), results));
  }
  const std::string table = wordLengthCsv(study.wire(), study.rows());
  write(a.out + "/" + a.wire + ".csv", table);
  std::cout << table;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Tries other fraction bits on one wire of the FPGA model"};
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
    settle(arguments);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : exit_usage;
  } catch (const ParameterError& error) {
    std::cerr << "word_length: " << error.what() << '\n';
    return exit_usage;
  }
  try {
    explore(arguments);
  } catch (const std::exception& error) {
    std::cerr << "word_length: " << error.what() << '\n';
    return exit_input;
  }
  return 0;
}
