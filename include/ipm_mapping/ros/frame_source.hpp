#pragma once

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <functional>
#include <optional>
#include <string>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/frame_gate.hpp"
#include "ipm_mapping/parameters.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/ros/camera_source.hpp"
#include "ipm_mapping/ros/image_subscriber.hpp"
#include "ipm_mapping/ros/odometry_source.hpp"
#include "ipm_mapping/ros/sequence_gaps.hpp"
#include "ipm_mapping/ros/stage_monitor.hpp"
#include "ipm_mapping/ros/waiting_clock.hpp"

namespace ipm_mapping {

/// What consumers of a frame's results need to know besides the frame.
struct FrameInfo {
  std_msgs::Header header;  ///< moved by image_time_offset and what is learnt; frame of the camera
  FrameNames frames;
  ros::Time image_stamp;  ///< as the camera sent it
};

/// Images with their poses, for every nodelet that starts from the camera: subscribes to
/// `image_raw`, `camera_info` and `odom` (or tf), lets frames wait for odometry, and hands them
/// over in order. Everything runs on the node handle's callback queue, one call at a time.
class FrameSource {
 public:
  struct Handlers {
    /// New calibration or camera pose: history is void.
    std::function<void(const CameraModel&, const CameraPose& T_base_camera)> camera;
    /// History is void.
    std::function<void(Restart)> reset;
    /// Takes the frame; the answer is counted. `frame.image` is of the calibrated size.
    std::function<FrameStatus(const Frame& frame, const FrameInfo& info)> frame;
    /// Detector::timeOffset(); may be left out.
    std::function<double()> time_offset = {};
  };

  FrameSource(ros::NodeHandle& node, ros::NodeHandle& private_node, const Parameters& parameters,
              StageMonitor& monitor, Handlers handlers);

  /// Applies from the next frame on; the camera is handed over anew.
  void setParameters(const CameraParameters& parameters);
  /// Subscribes, with an empty history.
  void start();
  void stop();
  [[nodiscard]] std::string imageTopic() const { return images_.topic(); }
  [[nodiscard]] std::string odometryTopic() const { return odometry_.topic(); }
  /// Where the camera's pose came from: "tf" or "parameters".
  [[nodiscard]] const char* poseSource() const { return camera_.poseSource(); }

 private:
  struct Waiting {
    std::uint64_t index = 0;
    CameraMessage message;
  };
  using Gate = FrameGate<Waiting>;

  void onImage(const CameraMessage& message);
  void onOdometry(double stamp, const SE2& T_odom_base);
  void pump();
  double now();
  bool cameraKnown();
  [[nodiscard]] bool patient() const;
  void process(const Gate::Released& frame);
  void restart(Restart cause, const char* why);
  [[nodiscard]] bool starting() const;
  void remindOfImages();
  void reportGate();
  [[nodiscard]] std::string missingOdometry() const;

  CameraParameters camera_parameters_;
  SourceParameters source_parameters_;
  OdometryParameters odometry_parameters_;
  StageMonitor& monitor_;
  Handlers handlers_;
  tf2_ros::Buffer tf_;
  tf2_ros::TransformListener tf_listener_;
  CameraSource camera_;
  OdometrySource odometry_;
  ImageSubscriber images_;
  Gate gate_;
  std::array<std::uint64_t, gate_drop_count> reported_drops_{};
  std::string optical_frame_;
  /// The first image without a known camera: its stamp, and when it came.
  struct FirstWaiting {
    double stamp;
    ros::WallTime arrival;
  };
  std::optional<FirstWaiting> waiting_since_;
  ros::WallTimer pumper_;
  WaitingClock waiting_clock_;
  ros::WallTime started_;
  ros::WallTime next_reminder_;
  SequenceGaps gaps_;
  bool any_pose_ = false;  // for a frame since then
  double newest_image_ = 0.0;
  std::uint64_t odometry_received_ = 0, odometry_refused_ = 0;
  OdometryVerdict refusal_ = OdometryVerdict::Accepted;
  int camera_revision_ = 0;
  std::uint64_t next_index_ = 0;
};

}  // namespace ipm_mapping
