// Is the camera where it is said to be? From the floor's own motion, in a bag or live.
// Exit codes: 0 done, 2 wrong usage, 3 input unreadable or missing, or too little floor motion.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include "ipm_mapping/ros/bag_arguments.hpp"
#include "ipm_mapping/ros/frame_faults.hpp"
#include "ipm_mapping/ros/live_run.hpp"
#include "ipm_mapping/ros/offline_run.hpp"
#include "ipm_mapping/sweep/camera_check.hpp"
#include "ipm_mapping/view/camera_check_picture.hpp"

namespace {

using namespace ipm_mapping;

constexpr double degrees = 180.0 / M_PI;

struct Arguments : BagArguments {
  std::string out = ".";
  bool live = false;
  LiveOptions live_options;

  void declareAll(CLI::App& app) {
    auto* bag = app.add_option("bag", options.bag, "recording with images and odometry");
    auto* flag = app.add_flag("--live", live, "listen to the robot instead")->excludes(bag);
    app.add_option("--seconds", live_options.seconds, "how long to listen (60)")
        ->needs(flag)
        ->check(positiveNumber());
    app.add_option("--image-transport", live_options.image_transport, "raw or compressed (raw)")
        ->needs(flag);
    app.add_option("--out", out, "folder for camera_check.png (made if missing; default: here)");
    declare(app);
  }
  void settleAll() {
    if (!live && options.bag.empty()) throw ParameterError("give a BAG, or --live");
    settle();
    settleForACheck(options.parameters.calibration);
  }
  /// Twice the samples, every pair of the drive, nothing fades; and whoever checks a height has
  /// more reason to doubt it than a detector that runs along.
  static void settleForACheck(CalibrationParameters& c) {
    constexpr double doubt = 4.0 / 3.0;
    c.sd_height_wrong *= doubt;
    c.row_step = std::max(1, c.row_step * 7 / 10);
    c.line_step = std::max(1, c.line_step * 7 / 10);
    c.correlation *= 0.5;
    c.settled_spacing = c.spacing;
    c.memory = 1e6;
  }
};

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[300];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Where the stated pose comes from, and which frames were lost through a fault; empty if none.
struct CheckedRun {
  std::string stated_from, lost;
};

/// What cannot be judged is an input error, in one line that says what to do.
CalibrationReport requireEstimate(const sweep::CameraCheck& check,
                                  const CalibrationParameters& parameters,
                                  const std::string& lost) {
  if (check.camera().width() == 0) throw BagError("no frame with a known camera came");
  const CalibrationReport report = *check.calibration();
  if (report.pairs < parameters.least_pairs)
    throw BagError(
        formatted("not enough floor motion: %d pairs of frames could be compared, %d are "
                  "needed; drive a metre or more over floor that has some texture",
                  report.pairs, parameters.least_pairs) +
        (lost.empty() ? "" : "; " + lost));
  if (!report.believable)
    throw BagError(
        formatted("the floor says pitch %.1f deg and height %.2f m, too far from the "
                  "stated %.1f deg and %.2f m to be believed; measure the pose and state "
                  "it with --camera-pose x,y,z,pitch",
                  degrees * report.pitch.estimate, report.height.estimate,
                  degrees * report.pitch.stated, report.height.stated));
  return report;
}

void printReport(const CalibrationReport& r, const sweep::CameraCheck& check) {
  std::printf("pitch_deg: %.3f +- %.3f (stated %.3f)\n", degrees * r.pitch.estimate,
              degrees * r.pitch.sigma, degrees * r.pitch.stated);
  std::printf("height_m: %.4f +- %.4f (stated %.4f)\n", r.height.estimate, r.height.sigma,
              r.height.stated);
  std::printf("roll_deg: %.3f +- %.3f (over the stated one)\n", degrees * r.roll.estimate,
              degrees * r.roll.sigma);
  std::printf("yaw_deg: %.3f +- %.3f (over the stated one)\n", degrees * r.yaw.estimate,
              degrees * r.yaw.sigma);
  std::printf("odometry_scale: %.4f +- %.4f (true way over odometry's)\n", r.scale.estimate,
              r.scale.sigma);
  std::printf(
      "height_over_scale_m: %.4f +- %.4f (what the floor shows; what is off is shared out "
      "by sd_height and sd_scale)\n",
      r.height.estimate / r.scale.estimate, r.height.estimate / r.scale.estimate * r.ratio_sigma);
  std::printf("odometry_turn_scale: %.4f +- %.4f\n", r.turn_scale.estimate, r.turn_scale.sigma);
  std::printf("odometry_yaw_rate_deg_s: %.3f +- %.3f (true over odometry's)\n",
              degrees * r.yaw_rate.estimate, degrees * r.yaw_rate.sigma);
  std::printf("readout_ms: %.1f +- %.1f (stated %.1f; a rolling shutter)\n",
              1000.0 * r.readout.estimate, 1000.0 * r.readout.sigma, 1000.0 * r.readout.stated);
  std::printf(
      "time_offset_ms: %.1f +- %.1f (from an image's stamp to when it was taken, by odometry's "
      "clock; over image_time_offset)\n",
      1000.0 * r.time_offset.estimate, 1000.0 * r.time_offset.sigma);
  std::printf(
      "registration_px: %.2f as stated, %.2f as estimated (median of %zu and %zu patches)\n",
      median(check.statedErrors()), median(check.estimatedErrors()), check.statedErrors().size(),
      check.estimatedErrors().size());
  std::printf("pairs: %d\n", r.pairs);
  std::printf("advice: %s\n", advice(r).c_str());
}

std::string poseWords(const char* which, const CalibrationReport::Value& pitch,
                      const CalibrationReport::Value& height, double CalibrationReport::Value::*of,
                      const std::vector<double>& errors) {
  return formatted(
      "%s: pitch %.2f deg, height %.3f m; horizon, floor every 0.5 m, what is left "
      "between two frames x 10 (median %.2f px)",
      which, degrees * (pitch.*of), height.*of, median(errors));
}

void writePicture(const CalibrationReport& r, const sweep::CameraCheck& check,
                  const std::string& out) {
  const sweep::RegistrationView& view = check.view();
  if (view.picture.empty()) return;
  using Value = CalibrationReport::Value;
  const CheckedPose stated{
      check.T_base_stated(), view.stated,
      poseWords("as stated", r.pitch, r.height, &Value::stated, check.statedErrors())};
  const CheckedPose estimated{
      check.T_base_estimated(), view.estimated,
      poseWords("as estimated", r.pitch, r.height, &Value::estimate, check.estimatedErrors())};
  std::filesystem::create_directories(out);
  const std::string path = (std::filesystem::path(out) / "camera_check.png").string();
  if (!cv::imwrite(
          path, drawCameraCheck(view.picture.view(), check.camera(), stated, estimated, advice(r))))
    throw std::runtime_error("cannot write '" + path + "'");
  std::printf("picture: %s\n", path.c_str());
}

CheckedRun runOnBag(const OfflineOptions& options, sweep::CameraCheck& check) {
  const BagSource bag(options.bag, options.topics);
  const RunCamera camera = resolveCamera(bag, options);
  OfflineRun run(bag, camera, options.parameters, check);
  run.run({});
  requireImages(run.report());
  printWarning(std::cout, camera.concern);
  return {camera.pose_source, dropConcern(run.report(), bag.topics())};
}

void runOn(const Arguments& a) {
  sweep::CameraCheck check(a.options.parameters.sweep, a.options.parameters.calibration);
  const CheckedRun run =
      a.live ? CheckedRun{runLive("check_camera", a.options, a.live_options, check), ""}
             : runOnBag(a.options, check);
  const CalibrationReport report =
      requireEstimate(check, a.options.parameters.calibration, run.lost);
  printWarning(std::cout, run.lost);
  std::printf("stated_pose_from: %s\n", run.stated_from.c_str());
  printReport(report, check);
  writePicture(report, check, a.out);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Checks where the camera is, from how the floor moves"};
  Arguments arguments;
  arguments.declareAll(app);
  return runTool(
      app, "check_camera", argc, argv, [&] { arguments.settleAll(); }, [&] { runOn(arguments); });
}
