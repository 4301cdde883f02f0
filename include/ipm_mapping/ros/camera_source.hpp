#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <sensor_msgs/CameraInfo.h>
#include <tf2/buffer_core.h>

#include <functional>
#include <string>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"
#include "ipm_mapping/ros/stage_monitor.hpp"

namespace ipm_mapping {

/// Says that the pose which the parameters state is taken, and why tf's is not.
[[nodiscard]] std::string statedPoseTaken(const CameraParameters& parameters,
                                          const std::string& optical_frame,
                                          const std::string& base_frame);

/// Where calibration and camera pose come from: camera_info, else the calibration file; tf, else
/// the parameters. Both first choices get some time before the second ones are taken.
class CameraSource {
 public:
  CameraSource(ros::NodeHandle& node, const tf2::BufferCore& tf, const CameraParameters& parameters,
               StageMonitor& monitor);

  /// A stated pose that is in force changes with the next update().
  void setParameters(const CameraParameters& parameters);
  /// Brings calibration and pose up to date for pictures of `optical_frame`; `patient`: a first
  /// choice that is missing may still come. True when both are known.
  bool update(const std::string& optical_frame, const std::string& base_frame, bool patient);

  [[nodiscard]] const CameraModel& model() const { return model_; }
  [[nodiscard]] const CameraPose& T_base_camera() const { return T_base_camera_; }
  /// "tf" or "parameters".
  [[nodiscard]] const char* poseSource() const;
  /// Another number means: model or pose changed.
  [[nodiscard]] int revision() const { return revision_; }
  /// What is missing, as a sentence.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  enum class Origin { None, FirstChoice, SecondChoice };

  void onInfo(const sensor_msgs::CameraInfoConstPtr& info);
  void takeInfo(const sensor_msgs::CameraInfo& info, const std::string& source, Origin origin);
  void takePose(const CameraPose& T_base_camera, const std::string& source, Origin origin);
  bool takeCalibrationFile();
  bool takeTransform(const std::string& optical_frame, const std::string& base_frame);
  void takeStatedPose(const std::string& optical_frame, const std::string& base_frame);

  const tf2::BufferCore& tf_;
  CameraParameters parameters_;
  StageMonitor& monitor_;
  ros::Subscriber subscriber_;
  Origin model_origin_ = Origin::None, pose_origin_ = Origin::None;
  bool file_refused_ = false, file_left_out_ = false, had_pose_ = false;
  std::string info_refusal_;
  CameraModel model_;
  CameraPose T_base_camera_ = CameraPose::Identity();
  int revision_ = 0;
  std::string complaint_;
};

}  // namespace ipm_mapping
