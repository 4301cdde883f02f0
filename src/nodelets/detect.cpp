#include <cmath>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <utility>

#include "ipm_mapping/detectors/contact_memory.hpp"
#include "ipm_mapping/detectors/pipeline.hpp"
#include "ipm_mapping/ros/calibration_diagnostics.hpp"
#include "ipm_mapping/ros/detector_pictures.hpp"
#include "ipm_mapping/ros/floor_localiser.hpp"
#include "ipm_mapping/ros/frame_source.hpp"
#include "ipm_mapping/ros/live_parameters.hpp"
#include "ipm_mapping/ros/obstacle_outputs.hpp"
#include "ipm_mapping/ros/overlay_output.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/refined_odometry.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"

namespace ipm_mapping {

/// Camera and odometry in, obstacles out: any detector in one piece, `detector/kind` names it.
class Detect : public StageNodelet {
  void start() override {
    const Parameters& parameters = parameters_ = loadParameters(privateNode());
    detector_ = makeDetector(parameters);
    memory_ = ContactMemory(parameters.memory);
    source_.emplace(
        node(), privateNode(), parameters, monitor(),
        FrameSource::Handlers{
            [this](const CameraModel& camera, const CameraPose& T_base_camera) {
              detector_->setCamera(camera, T_base_camera);
              memory_.clear();
            },
            [this](Restart cause) { forget(cause); },
            [this](const Frame& frame, const FrameInfo& info) { return process(frame, info); },
            [this] { return detector_->timeOffset(); }});
    monitor().setAsleep(true);
    obstacle_outputs_.emplace(node(), outputs_, parameters.output);
    refined_odometry_.emplace(node(), outputs_, parameters);
    const auto localiser = loadStruct<FloorLocaliserParameters>(privateNode());
    if (!localiser.map_frame.empty()) localiser_.emplace(localiser);
    overlay_ = outputs_.advertiseImage(node(), "overlay");
    difference_ = outputs_.advertiseImage(node(), "difference_image");
    score_ = outputs_.advertiseImage(node(), "score_image");
    live_.emplace(privateNode(), parameters, liveGroups(),
                  [this](const Parameters& changed) { change(changed); });
    if (localiser_) {  // tf has listeners that this nodelet does not see
      outputs_.stayAwake();
      setAwake(true);
    }
  }

  /// Everything but what the map and the odometry's gate are made with.
  static std::vector<std::string> liveGroups() {
    std::vector<std::string> groups;
    const Parameters parameters;
    Parameters::groups(parameters, [&](const std::string& name, const auto&) {
      if (name != "map" && name != "odometry") groups.push_back(name);
    });
    return groups;
  }

  void change(const Parameters& changed) {
    obstacle_outputs_->setParameters(changed.output);
    const std::vector<std::string> memory{"memory"};
    if (!(toConfig(changed, memory) == toConfig(parameters_, memory)))
      memory_ = ContactMemory(changed.memory);
    Parameters same = changed;
    same.output = parameters_.output;
    same.memory = parameters_.memory;
    const bool same_detector = toConfig(same, liveGroups()) == toConfig(parameters_, liveGroups());
    const std::vector<std::string> camera{"camera"};
    const bool same_camera = toConfig(changed, camera) == toConfig(parameters_, camera);
    parameters_ = changed;
    if (same_detector) return;
    const std::unique_ptr<Detector> before = std::exchange(detector_, makeDetector(changed));
    memory_.clear();
    refined_odometry_->setParameters(changed);
    if (!same_camera || !detector_->adopt(*before)) source_->setParameters(changed.camera);
  }

  void setAwake(bool awake) {
    monitor().setAsleep(!awake);
    guarded([&] { awake ? source_->start() : source_->stop(); });
  }

  void forget(Restart cause) {
    detector_->reset();
    memory_.clear();
    refined_odometry_->reset();
    if (localiser_) localiser_->restart(cause);
  }

  FrameStatus process(const Frame& frame, const FrameInfo& info) {
    const FrameStatus status = detector_->process(frame, obstacles_);
    const SE2& refined =
        refined_odometry_->follow(*detector_, frame, status, info.header.stamp, info.frames);
    if (localiser_)
      showCorrection(
          localiser_->publish(frame.T_odom_base, refined, info.header.stamp, info.frames));
    Frame placed = frame;
    if (placesByFloor()) placed.T_odom_base = refined;
    obstacles_.view.T_odom_base = placed.T_odom_base;
    if (memory_.follow(placed, status, obstacles_))
      obstacle_outputs_->publish(obstacles_, info.header.stamp, info.frames, detector_->id());
    if (status == FrameStatus::Used || status == FrameStatus::Watched) {
      publishOverlay(overlay_, frame.image, obstacles_, info.header);
      publishPictures(info.header);
    }
    monitor().set("contacts", static_cast<double>(obstacles_.contacts.size()));
    monitor().set("separability", obstacles_.separability);
    if (const auto calibration = detector_->calibration()) showCalibration(*calibration, monitor());
    monitor().set("stamps_moved_ms", 1000.0 * frame.time_offset);
    return status;
  }

  /// tf says already where the floor puts the wheels' frame: not twice.
  [[nodiscard]] bool placesByFloor() const {
    return parameters_.floor_odometry.poses == Poses::Refined && !localiser_;
  }

  void showCorrection(const SE2& T_map_odom) {
    monitor().set("map_odom_x_m", T_map_odom.x);
    monitor().set("map_odom_y_m", T_map_odom.y);
    monitor().set("map_odom_yaw_deg", T_map_odom.theta * 180.0 / M_PI);
  }

  void publishPictures(const std_msgs::Header& header) {
    if (difference_.getNumSubscribers() > 0 && differencePicture(*detector_, picture_))
      publishPicture(difference_, picture_.view(), header);
    if (score_.getNumSubscribers() > 0 &&
        scorePicture(*detector_, parameters_.sweep.selection.score_cap, picture_))
      publishPicture(score_, picture_.view(), header);
  }

  Parameters parameters_;
  std::unique_ptr<Detector> detector_;
  ContactMemory memory_;
  Obstacles obstacles_;
  std::optional<FrameSource> source_;
  LazyOutputs outputs_{[this](bool awake) { setAwake(awake); }};
  std::optional<ObstacleOutputs> obstacle_outputs_;
  std::optional<RefinedOdometry> refined_odometry_;
  std::optional<FloorLocaliser> localiser_;
  std::optional<LiveParameters> live_;
  image_transport::Publisher overlay_, difference_, score_;
  Image<std::uint8_t> picture_;
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::Detect, nodelet::Nodelet)
