#include "ipm_mapping/ros/offline_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "ipm_mapping/detectors/floor_observation.hpp"
#include "ipm_mapping/detectors/pipeline.hpp"
#include "ipm_mapping/ros/camera_info.hpp"
#include "ipm_mapping/ros/camera_source.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

sensor_msgs::CameraInfo calibrationOf(const BagSource& bag, const OfflineOptions& options,
                                      std::string& source) {
  sensor_msgs::CameraInfo info;
  std::string file = options.calibration_file;
  const auto recorded = file.empty() ? bag.cameraInfo() : std::nullopt;
  if (file.empty() && !recorded) file = options.parameters.camera.calibration_file;
  if (!file.empty()) {
    if (const Refusal refusal = readCalibrationFile(file, info)) throw BagError(*refusal);
    source = file;
    return info;
  }
  if (!recorded)
    throw BagError("the bag has no camera_info: give the calibration with --camera-info FILE.yaml");
  source = bag.topics().camera_info;
  return *recorded;
}

/// Says that a pose which was set by hand is not the one that is taken.
std::string ineffective(const std::vector<std::string>& settings) {
  if (settings.empty()) return {};
  std::string names;
  for (const std::string& name : settings) names += (names.empty() ? "" : ", ") + name;
  return names +
         " without effect: tf knows the camera's pose, and it is taken; set "
         "camera/pose_from_tf=false to use the parameters' instead";
}

}  // namespace

RunCamera resolveCamera(const BagSource& bag, const OfflineOptions& options) {
  RunCamera camera;
  const auto info = calibrationOf(bag, options, camera.calibration_source);
  if (const Refusal refusal = toCamera(info, camera.model))
    throw BagError(camera.calibration_source + ": " + *refusal);

  const CameraParameters& p = options.parameters.camera;
  const auto from_tf = options.camera_pose || !p.pose_from_tf ? std::nullopt : bag.cameraPose();
  if (options.camera_pose) {
    const auto& [x, y, z, pitch] = *options.camera_pose;
    camera.T_base_camera = cameraPose(x, y, z, pitch);
    camera.pose_source = "command line";
  } else if (from_tf) {
    camera.T_base_camera = *from_tf;
    camera.pose_source = "tf";
    camera.concern = ineffective(options.pose_settings);
  } else {
    camera.T_base_camera = cameraPose(p.x, p.y, p.z, p.pitch, p.yaw, p.roll);
    camera.pose_source = "parameters";
    if (p.pose_from_tf) camera.concern = statedPoseTaken(p, bag.frameOfImages(), bag.baseFrame());
  }
  if (const auto error = checkCameraPose(camera.T_base_camera))
    throw BagError(camera.pose_source + ": " + *error);
  return camera;
}

double StageStatistics::median() const {
  if (samples.empty()) return 0.0;
  std::vector<double> sorted = samples;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

double StageStatistics::total() const {
  double sum = 0.0;
  for (const double s : samples) sum += s;
  return sum;
}

void RunReport::addStage(const char* stage, double seconds) {
  for (auto& [known, statistics] : stages) {
    if (known != stage) continue;
    statistics.samples.push_back(seconds);
    return;
  }
  stages.emplace_back(stage, StageStatistics{{seconds}});
}

void requireImages(const RunReport& report) {
  if (report.images == 0) throw BagError("the image topic has no messages");
  if (report.unusable_images == report.images) throw BagError(report.first_refusal);
  const auto status = [&](FrameStatus s) { return report.frames[static_cast<std::size_t>(s)]; };
  if (status(FrameStatus::SizeMismatch) > 0 && report.used() == 0)
    throw BagError(
        "images are not of the calibrated size; give the right calibration with "
        "--camera-info FILE.yaml");
  if (report.odometry.empty()) throw BagError("the odometry topic has no messages");
}

OfflineRun::OfflineRun(const BagSource& bag, const RunCamera& camera, const Parameters& parameters)
    : bag_(bag),
      parameters_(parameters),
      own_detector_(makeDetector(parameters)),
      detector_(*own_detector_),
      gate_(parameters.odometry),
      map_(parameters.map),
      confirmation_(parameters.memory),
      floor_odometry_(parameters.sweep, parameters.floor_odometry) {
  detector_.setCamera(camera.model, camera.T_base_camera);
}

OfflineRun::OfflineRun(const BagSource& bag, const RunCamera& camera, const Parameters& parameters,
                       Detector& detector)
    : bag_(bag),
      parameters_(parameters),
      detector_(detector),
      gate_(parameters.odometry),
      map_(parameters.map),
      confirmation_(parameters.memory),
      floor_odometry_(parameters.sweep, parameters.floor_odometry) {
  detector_.setCamera(camera.model, camera.T_base_camera);
}

OfflineRun::~OfflineRun() = default;

void OfflineRun::restart() {
  detector_.reset();
  floor_odometry_.reset();
  confirmation_.clear();
  ++report_.resets;
}

void OfflineRun::addImage(const BagSource::Image& image) {
  const std::uint64_t index = next_index_++;
  ++report_.images;
  if (!image.picture) {
    ++report_.unusable_images;
    if (report_.first_refusal.empty()) report_.first_refusal = image.refusal;
    return;
  }
  const double stamp = image.stamp + parameters_.camera.image_time_offset;
  if (gate_.addFrame(stamp, {index, *image.picture}, image.arrival)) restart();
}

void OfflineRun::addOdometry(double stamp, double arrival, const nav_msgs::Odometry& odometry) {
  OdometryVerdict verdict = OdometryVerdict::Accepted;
  if (gate_.addOdometry(stamp, toSE2(odometry.pose.pose), arrival, &verdict)) restart();
  ++report_.odometry[name(verdict)];
}

void OfflineRun::process(const FrameGate<std::pair<std::uint64_t, GrayPicture>>::Released& frame,
                         const Observers& observers) {
  const auto& [index, picture] = frame.payload;
  const auto start = Clock::now();
  const Frame now{index,          frame.stamp,      picture.view, frame.T_odom_base,
                  frame.velocity, frame.time_offset};
  const FrameStatus status = detector_.process(now, obstacles_);
  gate_.setTimeOffset(detector_.timeOffset());
  ++report_.frames[static_cast<std::size_t>(status)];
  trajectory_.push_back({index, frame.stamp, frame.T_odom_base,
                         floor_odometry_.add(floorObservation(detector_, now, status))});
  if (parameters_.floor_odometry.poses == Poses::Refined)
    obstacles_.view.T_odom_base = floor_odometry_.pose().T_odom_base;
  if (status == FrameStatus::Used || status == FrameStatus::Watched)
    confirmation_.apply(obstacles_);
  if (status == FrameStatus::Used) {
    for (const StageTime& time : detector_.stageTimes()) report_.addStage(time.stage, time.seconds);
    const auto before_map = Clock::now();
    map_.update(obstacles_);
    report_.addStage("map", secondsSince(before_map));
    report_.contacts += obstacles_.contacts.size();
  }
  if (status != FrameStatus::Watched) report_.processing_seconds += secondsSince(start);
  if (status == FrameStatus::Used && observers.used) observers.used(obstacles_, picture.view);
  if (status == FrameStatus::Watched && observers.watched)
    observers.watched(obstacles_, picture.view);
  if (observers.frame && !observers.frame(index, status, picture.view)) ended_ = true;
}

void OfflineRun::processReady(const Observers& observers) {
  FrameGate<std::pair<std::uint64_t, GrayPicture>>::Released frame;
  while (!ended_ && gate_.next(frame)) process(frame, observers);
}

void OfflineRun::run(const Observers& observers) {
  const auto start = Clock::now();
  bag_.read({[&](const BagSource::Image& image) {
               addImage(image);
               processReady(observers);
             },
             [&](double stamp, double arrival, const nav_msgs::Odometry& odometry) {
               addOdometry(stamp, arrival, odometry);
               processReady(observers);
             },
             observers.progress, [this] { return ended_; }});
  gate_.finish();
  // A run that found nothing still has a map: all of it unknown.
  if (map_.geometry().empty())
    map_.include(trajectory_.empty() ? Eigen::Vector2d::Zero()
                                     : trajectory_.front().T_odom_base.translation());
  for (int i = 0; i < gate_drop_count; ++i)
    report_.gate_drops[static_cast<std::size_t>(i)] = gate_.dropped(static_cast<GateDrop>(i));
  report_.wall_seconds = secondsSince(start);
}

}  // namespace ipm_mapping
