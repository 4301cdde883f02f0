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
#include "ipm_mapping/ros/bag_arguments.hpp"
#include "ipm_mapping/ros/frame_faults.hpp"
#include "ipm_mapping/ros/offline_run.hpp"

namespace {

using namespace ipm_mapping;

struct Arguments : BagArguments {
  std::string out;
  std::string wire = "homography_linear";
  std::string bits = "4..16";
  std::size_t pairs = 8;
  int first = 0, last = 0;
};

std::string wireNames() {
  std::string names;
  for (const char* each : fpga::explored_wire_names)
    names += (names.empty() ? "" : ", ") + std::string(each);
  return names;
}

void declareAll(CLI::App& app, Arguments& a) {
  app.add_option("bag", a.options.bag, "recording with images and odometry")->required();
  app.add_option("--wire", a.wire, wireNames());
  app.add_option("--bits", a.bits, "fraction bits to try: A..B, or one number");
  app.add_option("--pairs", a.pairs, "frame pairs, spread over the bag: so many to twice as many")
      ->check(CLI::Range(1, 1000));
  app.add_option("--out", a.out, "folder for the tables (made if missing)")->required();
  a.declare(app);
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

void settleAll(Arguments& a) {
  if (!fpga::exploredWire(a.wire))
    throw ParameterError("--wire " + a.wire + " is not known; there are: " + wireNames());
  readBits(a);
  a.settle();
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

/// Frame pairs of the bag as the model meets them, with their history and threshold register.
std::vector<OwnedPair> readPairs(const Arguments& a) {
  const BagSource bag(a.options.bag, a.options.topics);
  const RunCamera camera = resolveCamera(bag, a.options);
  printWarning(std::cerr, camera.concern);
  FpgaDetector detector(a.options.parameters);
  OfflineRun run(bag, camera, a.options.parameters, detector);
  if (detector.cameraError()) throw BagError(*detector.cameraError());
  SpreadPairs kept(a.pairs);
  OfflineRun::Observers observers;
  observers.used = [&](const Obstacles& obstacles, GrayView raw) {
    kept.offer(detector, obstacles, raw);
  };
  run.run(observers);
  if (kept.pairs().empty()) throw BagError(frameConcern(run.report(), bag.topics()));
  return kept.pairs();
}

void write(const std::string& path, const std::string& text) {
  if (const auto error = writeFileAtomically(path, text)) throw std::runtime_error(*error);
}

void explore(const Arguments& a) {
  WordLengthStudy study(a.options.parameters, *fpga::exploredWire(a.wire), a.first, a.last);
  std::filesystem::create_directories(a.out);
  for (const OwnedPair& pair : readPairs(a)) {
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
  declareAll(app, arguments);
  return runTool(
      app, "word_length", argc, argv, [&] { settleAll(arguments); }, [&] { explore(arguments); });
}
