// Maps a bag as fast as disk and processor allow, through the classes that the nodelets use.
// Exit codes: 0 done, 2 wrong usage, 3 input unreadable or missing.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>

#include "ipm_mapping/detectors/fpga_statistics.hpp"
#include "ipm_mapping/fpga/fifo.hpp"
#include "ipm_mapping/io/run_files.hpp"
#include "ipm_mapping/kernels/simd_target.hpp"
#include "ipm_mapping/mapping/map_io.hpp"
#include "ipm_mapping/ros/bag_arguments.hpp"
#include "ipm_mapping/ros/frame_faults.hpp"
#include "ipm_mapping/ros/offline_run.hpp"
#include "ipm_mapping/ros/report_json.hpp"
#include "ipm_mapping/view/map_picture.hpp"
#include "ipm_mapping/view/overlay.hpp"

namespace {

using namespace ipm_mapping;

struct Arguments : BagArguments {
  std::string out;
  std::string truth;
  std::string simd;
  int overlays = 0;
  bool fpga = false, temporal_filter = false, standing = false;

  void declareAll(CLI::App& app) {
    app.add_option("bag", options.bag, "recording with images and odometry")->required();
    app.add_option("--out", out, "folder for the results (made if missing)")->required();
    declare(app);
    app.add_flag("--fpga", fpga, "let the bit-true FPGA model find the obstacles");
    app.add_flag("--temporal-filter", temporal_filter,
                 "only contacts seen in several of the last used frames (memory/filter)");
    app.add_flag("--standing", standing,
                 "tables and overlays also of frames in which the robot stands and looks on");
    app.add_option("--truth", truth, "truth.json of a rendered scene, drawn into map.png");
    app.add_option("--overlays", overlays, "draw every N-th used frame into overlays/NNNNNN.png")
        ->check(positiveNumber());
    app.add_option("--simd", simd,
                   "widest instruction set to use, e.g. AVX2: results stay, times do not");
  }
  void settleAll() {
    settle();
    if (!simd.empty())
      if (const auto error = kernels::limitSimd(simd)) throw CLI::ValidationError("--simd", *error);
    options.parameters.memory.filter |= temporal_filter;
    if (fpga) options.parameters.detector.kind = DetectorKind::Fpga;
  }
};

/// One line that is redrawn, on terminals only.
void showProgress(double share) {
  static const bool terminal = isatty(STDERR_FILENO) == 1;
  static int shown = -1;
  const int percent = static_cast<int>(100.0 * share);
  if (!terminal || percent == shown) return;
  shown = percent;
  constexpr int width = 40;
  const int filled = percent * width / 100;
  std::fprintf(stderr, "\r[%s%s] %3d %%%s",
               std::string(static_cast<std::size_t>(filled), '#').c_str(),
               std::string(static_cast<std::size_t>(width - filled), '.').c_str(), percent,
               percent == 100 ? "\n" : "");
}

void writeText(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("cannot write '" + path + "'");
}

void summarize(const OfflineRun& run, const RunCamera& camera, const BagTopics& topics) {
  const RunReport& r = run.report();
  const auto ms = r.used() > 0 ? 1e3 * r.processing_seconds / static_cast<double>(r.used()) : 0.0;
  std::printf("%llu frames read, %llu used, %llu contacts, %.2f ms a used frame\n",
              static_cast<unsigned long long>(r.images), static_cast<unsigned long long>(r.used()),
              static_cast<unsigned long long>(r.contacts), ms);
  printWarning(std::cout, camera.concern);
  printWarning(std::cout, frameConcern(r, topics));
  if (const auto calibration = run.detector().calibration())
    printWarning(std::cout, concern(*calibration));
}

void writePicture(const std::string& path, const cv::Mat& picture) {
  if (!cv::imwrite(path, picture)) throw std::runtime_error("cannot write '" + path + "'");
}

/// The most telling frame of the run: the one with the most contacts.
class OverlayFrame {
 public:
  void offer(const Obstacles& obstacles, GrayView raw) {
    if (!picture_.empty() && obstacles.contacts.size() <= obstacles_.contacts.size()) return;
    obstacles_ = obstacles;
    picture_.ensure(raw.width, raw.height);
    for (int v = 0; v < raw.height; ++v) std::copy_n(raw.row(v), raw.width, picture_.row(v));
  }
  [[nodiscard]] bool empty() const { return picture_.empty(); }
  /// Without a frame, the picture of an earlier run goes.
  void write(const std::string& path) const {
    if (empty())
      std::filesystem::remove(path);
    else
      writePicture(path, drawOverlay(picture_.view(), obstacles_));
  }

 private:
  Obstacles obstacles_;
  Image<std::uint8_t> picture_;
};

/// A film of the run: every N-th used frame, named after its number in the bag. That of an earlier
/// run goes.
class OverlaySeries {
 public:
  OverlaySeries(const std::string& out, int every) : folder_(out + "/overlays"), every_(every) {
    if (every_ == 0) return;
    std::filesystem::create_directories(folder_);
    removeEarlier();
  }
  void offer(const Obstacles& obstacles, GrayView raw) {
    if (every_ == 0 || used_++ % every_ != 0) return;
    char name[32];
    std::snprintf(name, sizeof name, "/%06llu.png",
                  static_cast<unsigned long long>(obstacles.frame));
    writePicture(folder_ + name, drawOverlay(raw, obstacles));
  }
  [[nodiscard]] bool empty() const { return every_ == 0 || used_ == 0; }

 private:
  void removeEarlier() const {
    static const std::regex named("[0-9]{6,}\\.png");
    std::vector<std::filesystem::path> earlier;
    for (const auto& file : std::filesystem::directory_iterator(folder_))
      if (file.is_regular_file() && std::regex_match(file.path().filename().string(), named))
        earlier.push_back(file.path());
    for (const auto& path : earlier) std::filesystem::remove(path);
  }

  std::string folder_;
  int every_, used_ = 0;
};

/// Outlines of a truth.json.
std::vector<Outline> readTruth(const std::string& path) {
  std::vector<Outline> outlines;
  if (path.empty()) return outlines;
  std::ifstream file(path);
  if (!file) throw BagError("cannot read '" + path + "'");
  try {
    const auto truth = nlohmann::json::parse(file);
    for (const auto& footprint : truth.at("footprints")) {
      Outline outline;
      outline.closed = footprint.contains("polygon");
      for (const auto& point : footprint.at(outline.closed ? "polygon" : "polyline"))
        outline.points.emplace_back(point.at(0).get<double>(), point.at(1).get<double>());
      outlines.push_back(std::move(outline));
    }
  } catch (const nlohmann::json::exception& error) {
    throw BagError("'" + path + "' is not a truth file: " + error.what());
  }
  return outlines;
}

void writeMap(const OfflineRun& run, const Arguments& a) {
  TrinaryMap map;
  run.map().copyTo(map);
  if (const auto error = saveMap(map, a.out + "/map")) throw std::runtime_error(*error);
  const std::string title = std::filesystem::path(a.options.bag).stem().string();
  std::vector<SE2> way;
  const bool refined = a.options.parameters.floor_odometry.poses == Poses::Refined;
  for (const TrackedFrame& frame : run.trajectory())
    way.push_back(refined ? frame.refined.T_odom_base : frame.T_odom_base);
  writePicture(a.out + "/map.png", drawMap(map, {title, way, readTruth(a.truth)}));
}

/// What only the FPGA model leaves: its FIFO's words (fifo.bin) and a part of the report.
class FpgaFiles {
 public:
  FpgaFiles(const Arguments& a, const Detector& detector)
      : model_(dynamic_cast<const FpgaDetector*>(&detector)),
        statistics_(a.options.parameters.fpga_clock),
        path_(a.out + "/fifo.bin") {
    if (model_ == nullptr) {
      std::filesystem::remove(path_);  // of an earlier run: it would pass for this one's
      return;
    }
    if (model_->cameraError()) throw BagError(*model_->cameraError());
    fifo_.open(path_, std::ios::binary);
  }
  /// After every used frame.
  void add() {
    if (model_ == nullptr) return;
    statistics_.add(*model_);
    fpga::writeFifo(fifo_, model_->results().selected);
  }
  void finish() {
    if (model_ == nullptr) return;
    fifo_.close();
    if (!fifo_) throw std::runtime_error("cannot write '" + path_ + "'");
  }
  [[nodiscard]] const FpgaStatistics* statistics() const {
    return model_ == nullptr ? nullptr : &statistics_;
  }

 private:
  const FpgaDetector* model_;
  FpgaStatistics statistics_;
  std::string path_;
  std::ofstream fifo_;
};

void listResults(const std::string& out, const OverlayFrame& overlay, const OverlaySeries& series,
                 const FpgaFiles& fpga_files) {
  std::printf(
      "results in %s: map.png, %smap.pgm, map.yaml, points.csv, obstacles.csv, trajectory.csv, "
      "%s%sreport.json\n",
      out.c_str(), overlay.empty() ? "" : "overlay.png, ", series.empty() ? "" : "overlays/, ",
      fpga_files.statistics() == nullptr ? "" : "fifo.bin, ");
}

void runOn(Arguments& a) {
  const BagSource bag(a.options.bag, a.options.topics);
  const RunCamera camera = resolveCamera(bag, a.options);
  std::filesystem::create_directories(a.out);
  RunFiles files(a.out);
  OfflineRun run(bag, camera, a.options.parameters);
  OverlayFrame overlay;
  OverlaySeries series(a.out, a.overlays);
  FpgaFiles fpga_files(a, run.detector());
  OfflineRun::Observers observers;
  observers.used = [&](const Obstacles& obstacles, GrayView raw) {
    files.add(obstacles);
    fpga_files.add();
    overlay.offer(obstacles, raw);
    series.offer(obstacles, raw);
  };
  if (a.standing)
    observers.watched = [&](const Obstacles& obstacles, GrayView raw) {
      files.add(obstacles);
      series.offer(obstacles, raw);
    };
  observers.progress = showProgress;
  run.run(observers);
  requireImages(run.report());
  files.finish();
  writeTrajectory(a.out, run.trajectory());
  fpga_files.finish();
  writeMap(run, a);
  overlay.write(a.out + "/overlay.png");
  writeText(a.out + "/report.json",
            reportJson(run, bag, camera, a.options, a.profile, fpga_files.statistics()));
  summarize(run, camera, bag.topics());
  listResults(a.out, overlay, series, fpga_files);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Maps the obstacles of a bag: one camera, odometry, a flat floor"};
  Arguments arguments;
  arguments.declareAll(app);
  return runTool(
      app, "offline_mapper", argc, argv, [&] { arguments.settleAll(); }, [&] { runOn(arguments); });
}
