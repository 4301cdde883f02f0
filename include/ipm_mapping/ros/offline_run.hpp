#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/detectors/contact_confirmation.hpp"
#include "ipm_mapping/frame_gate.hpp"
#include "ipm_mapping/io/run_files.hpp"
#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "ipm_mapping/parameters.hpp"
#include "ipm_mapping/ros/bag_source.hpp"

namespace ipm_mapping {

/// Calibration and camera pose of a run, and where each came from.
struct RunCamera {
  CameraModel model;
  CameraPose T_base_camera = CameraPose::Identity();
  std::string calibration_source;
  std::string pose_source;
  std::string concern;  ///< where the pose may not be the one that was meant; empty: nowhere
};

/// What to run on a bag.
struct OfflineOptions {
  std::string bag;
  BagTopics topics;
  std::string calibration_file;                      ///< overrides the bag's camera_info
  std::optional<std::array<double, 4>> camera_pose;  ///< x, y, z (m), pitch (rad): overrides tf
  Parameters parameters;
  std::vector<std::string> pose_settings;  ///< those of camera/x ... roll that were set by hand
};

/// Calibration and pose from the options, else the bag, else the parameters; throws BagError.
[[nodiscard]] RunCamera resolveCamera(const BagSource& bag, const OfflineOptions& options);

/// Time of one stage over a run, seconds.
struct StageStatistics {
  std::vector<double> samples;
  [[nodiscard]] double median() const;
  [[nodiscard]] double total() const;
};

/// Counts and times of a run.
struct RunReport {
  std::uint64_t images = 0;
  std::uint64_t unusable_images = 0;  ///< refused encodings and sizes that contradict themselves
  std::string first_refusal;
  std::array<std::uint64_t, frame_status_count> frames{};  ///< by FrameStatus
  std::array<std::uint64_t, gate_drop_count> gate_drops{};
  std::map<std::string, std::uint64_t> odometry;  ///< by verdict
  std::uint64_t resets = 0;
  std::uint64_t contacts = 0;
  std::vector<std::pair<std::string, StageStatistics>> stages;
  double processing_seconds = 0.0;  ///< detector and map, but for a robot that looks on
  double wall_seconds = 0.0;        ///< with reading and decoding

  [[nodiscard]] std::uint64_t used() const {
    return frames[static_cast<std::size_t>(FrameStatus::Used)];
  }
  void addStage(const char* stage, double seconds);
};

/// An input that gave nothing to work on is an error, a robot that never moved is not: throws
/// BagError.
void requireImages(const RunReport& report);

/// The chain from bag to map, through the classes that the nodelets use: frames wait for odometry
/// in the gate, the detector answers, the map takes the answer.
class OfflineRun {
 public:
  /// With the detector that the parameters name.
  OfflineRun(const BagSource& bag, const RunCamera& camera, const Parameters& parameters);
  /// With a detector of the caller's, whose camera is set here; it has to outlive the run.
  OfflineRun(const BagSource& bag, const RunCamera& camera, const Parameters& parameters,
             Detector& detector);
  ~OfflineRun();

  struct Observers {
    /// After every used frame, with the raw picture.
    std::function<void(const Obstacles&, GrayView raw)> used;
    /// After every frame in which the robot stood and looked on.
    std::function<void(const Obstacles&, GrayView raw)> watched;
    /// After every frame that reached the detector; false ends the run.
    std::function<bool(std::uint64_t index, FrameStatus, GrayView raw)> frame;
    std::function<void(double share)> progress;  ///< 0..1
  };
  void run(const Observers& observers);

  [[nodiscard]] const OccupancyMap& map() const { return map_; }
  [[nodiscard]] const RunReport& report() const { return report_; }
  [[nodiscard]] const Detector& detector() const { return detector_; }
  /// Robot poses at the stamps of all frames that reached the detector.
  [[nodiscard]] const std::vector<TrackedFrame>& trajectory() const { return trajectory_; }

 private:
  void addImage(const BagSource::Image& image);
  void addOdometry(double stamp, double arrival, const nav_msgs::Odometry& odometry);
  void processReady(const Observers& observers);
  void process(const FrameGate<std::pair<std::uint64_t, GrayPicture>>::Released& frame,
               const Observers& observers);
  void restart();

  const BagSource& bag_;
  Parameters parameters_;
  std::unique_ptr<Detector> own_detector_;
  Detector& detector_;
  FrameGate<std::pair<std::uint64_t, GrayPicture>> gate_;
  OccupancyMap map_;
  ContactConfirmation confirmation_;
  Obstacles obstacles_;
  RunReport report_;
  sweep::FloorOdometry floor_odometry_;
  std::vector<TrackedFrame> trajectory_;
  std::uint64_t next_index_ = 0;
  bool ended_ = false;
};

}  // namespace ipm_mapping
