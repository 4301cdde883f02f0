#include "ipm_mapping/ros/camera_source.hpp"

#include <tf2_eigen/tf2_eigen.h>

#include <tuple>

#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/ros/camera_info.hpp"
#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

/// A pose from tf that differs by less (metres, sine) is the same pose computed again.
constexpr double pose_tolerance = 1e-4;

bool sameStatedPose(const CameraParameters& a, const CameraParameters& b) {
  return std::tie(a.x, a.y, a.z, a.pitch, a.yaw, a.roll) ==
         std::tie(b.x, b.y, b.z, b.pitch, b.yaw, b.roll);
}

/// Why tf has no pose of the camera.
std::string unknownToTf(const std::string& optical_frame, const std::string& base_frame) {
  if (optical_frame.empty()) return "the images name no frame_id";
  if (base_frame.empty()) return "the odometry names no child_frame_id";
  return sentence("tf does not know '", optical_frame, "' in '", base_frame, "'");
}

}  // namespace

std::string statedPoseTaken(const CameraParameters& p, const std::string& optical_frame,
                            const std::string& base_frame) {
  return sentence(unknownToTf(optical_frame, base_frame),
                  ": the camera pose is taken from the parameters camera/x ... roll (", p.x, ", ",
                  p.y, ", ", p.z, " m, pitch ", p.pitch, " rad)");
}

CameraSource::CameraSource(ros::NodeHandle& node, const tf2::BufferCore& tf,
                           const CameraParameters& parameters, StageMonitor& monitor)
    : tf_(tf), parameters_(parameters), monitor_(monitor) {
  subscriber_ = node.subscribe("camera_info", 10, &CameraSource::onInfo, this);
}

void CameraSource::setParameters(const CameraParameters& parameters) {
  if (!parameters.pose_from_tf || pose_origin_ == Origin::SecondChoice) pose_origin_ = Origin::None;
  if (pose_origin_ == Origin::FirstChoice && parameters.pose_from_tf &&
      !sameStatedPose(parameters, parameters_))
    monitor_.warn(
        "camera/x ... roll have no effect while tf knows the camera, unless camera/pose_from_tf is "
        "false");
  file_refused_ = file_left_out_ = false;
  parameters_ = parameters;
}

void CameraSource::onInfo(const sensor_msgs::CameraInfoConstPtr& info) {
  takeInfo(*info, subscriber_.getTopic(), Origin::FirstChoice);
}

void CameraSource::takeInfo(const sensor_msgs::CameraInfo& info, const std::string& source,
                            Origin origin) {
  CameraModel model;
  if (const Refusal refusal = toCamera(info, model)) {
    info_refusal_ = source + ": " + *refusal;
    model_origin_ = Origin::None;
    monitor_.warn(info_refusal_);
    return;
  }
  info_refusal_.clear();
  model_origin_ = origin;
  if (origin == Origin::FirstChoice && !parameters_.calibration_file.empty() && !file_left_out_) {
    file_left_out_ = true;
    monitor_.warn(sentence("camera/calibration_file is not used: there is camera_info on ",
                           subscriber_.getTopic()));
  }
  if (model == model_) return;
  model_ = model;
  ++revision_;
}

bool CameraSource::takeCalibrationFile() {
  if (parameters_.calibration_file.empty() || file_refused_) return false;
  sensor_msgs::CameraInfo info;
  const Refusal refusal = readCalibrationFile(parameters_.calibration_file, info);
  if (!refusal) takeInfo(info, parameters_.calibration_file, Origin::SecondChoice);
  file_refused_ = refusal || model_origin_ == Origin::None;
  if (refusal) info_refusal_ = *refusal;
  return !file_refused_;
}

void CameraSource::takePose(const CameraPose& T_base_camera, const std::string& source,
                            Origin origin) {
  if (const auto error = checkCameraPose(T_base_camera)) {
    complaint_ = source + ": " + *error;
    pose_origin_ = Origin::None;
    return;
  }
  const bool first = pose_origin_ == Origin::None;
  pose_origin_ = origin;
  const auto change = (T_base_camera.matrix() - T_base_camera_.matrix()).cwiseAbs().maxCoeff();
  if (had_pose_ && change < pose_tolerance) return;
  had_pose_ = true;
  if (!first) monitor_.warn("camera pose changed, history starts anew");
  T_base_camera_ = T_base_camera;
  ++revision_;
}

bool CameraSource::takeTransform(const std::string& optical_frame, const std::string& base_frame) {
  if (optical_frame.empty() || !tf_.canTransform(base_frame, optical_frame, ros::Time(0)))
    return false;
  try {
    const auto transform = tf_.lookupTransform(base_frame, optical_frame, ros::Time(0));
    takePose(tf2::transformToEigen(transform), sentence("tf ", base_frame, " <- ", optical_frame),
             Origin::FirstChoice);
  } catch (const tf2::TransformException&) {
    return false;
  }
  return true;
}

void CameraSource::takeStatedPose(const std::string& optical_frame, const std::string& base_frame) {
  const CameraParameters& p = parameters_;
  if (p.pose_from_tf) monitor_.warn(statedPoseTaken(p, optical_frame, base_frame));
  takePose(cameraPose(p.x, p.y, p.z, p.pitch, p.yaw, p.roll), "parameters camera/x ... roll",
           p.pose_from_tf ? Origin::SecondChoice : Origin::FirstChoice);
}

const char* CameraSource::poseSource() const {
  return parameters_.pose_from_tf && pose_origin_ == Origin::FirstChoice ? "tf" : "parameters";
}

bool CameraSource::update(const std::string& optical_frame, const std::string& base_frame,
                          bool patient) {
  complaint_.clear();
  const bool from_tf = parameters_.pose_from_tf && takeTransform(optical_frame, base_frame);
  if (!from_tf && pose_origin_ == Origin::None && complaint_.empty() &&
      !(patient && parameters_.pose_from_tf))
    takeStatedPose(optical_frame, base_frame);
  if (model_origin_ == Origin::None && !patient && !takeCalibrationFile())
    complaint_ = !info_refusal_.empty() ? info_refusal_
                                        : sentence("no camera_info on ", subscriber_.getTopic(),
                                                   " and no camera/calibration_file");
  return model_origin_ != Origin::None && pose_origin_ != Origin::None;
}

}  // namespace ipm_mapping
