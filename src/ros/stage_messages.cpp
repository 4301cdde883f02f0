#include "ipm_mapping/ros/stage_messages.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using PoseRows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

static_assert(int{ObstacleBearing::UNKNOWN} == static_cast<int>(BearingState::Unknown));
static_assert(int{ObstacleBearing::FREE} == static_cast<int>(BearingState::Free));
static_assert(int{ObstacleBearing::OCCUPIED} == static_cast<int>(BearingState::Occupied));
static_assert(int{ObstacleBearing::BLOCKED} == static_cast<int>(BearingState::Blocked));

geometry_msgs::Pose2D toMessage(const SE2& pose) {
  geometry_msgs::Pose2D message;
  message.x = pose.x;
  message.y = pose.y;
  message.theta = pose.theta;
  return message;
}

SE2 fromMessage(const geometry_msgs::Pose2D& message) {
  return {message.x, message.y, message.theta};
}

template <class Numbers>
bool allFinite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

Refusal cameraFromMessage(const ViewGeometry& message, GroundView& view) {
  const Intrinsics k{static_cast<int>(message.width),
                     static_cast<int>(message.height),
                     message.K[0],
                     message.K[4],
                     message.K[2],
                     message.K[5]};
  const std::vector<double> D(message.D.begin(), message.D.end());
  if (auto error = CameraModel::check(k, "plumb_bob", D)) return "view: " + *error;
  const Distortion distortion = CameraModel::distortionFrom(D);
  // The turning radius is searched for once, not with every message.
  if (!(view.camera.intrinsics() == k && view.camera.distortion() == distortion))
    view.camera = CameraModel(k, distortion);
  return std::nullopt;
}

void toMessage(const Contact& contact, ObstacleContact& message) {
  message.bearing = static_cast<std::uint16_t>(contact.bearing);
  message.u = contact.u;
  message.v = contact.v;
  message.x = contact.p_base.x();
  message.y = contact.p_base.y();
  message.score = contact.score;
  message.height = contact.height;
  message.range_sigma = contact.range_sigma;
  message.moving = contact.moving;
  message.age = contact.age;
}

Contact fromMessage(const ObstacleContact& message) {
  Contact contact;
  contact.bearing = message.bearing;
  contact.u = message.u;
  contact.v = message.v;
  contact.p_base = {message.x, message.y};
  contact.score = message.score;
  contact.height = message.height;
  contact.range_sigma = message.range_sigma;
  contact.moving = message.moving != 0;
  contact.age = message.age;
  return contact;
}

void toMessage(const Bearing& bearing, ObstacleBearing& message) {
  message.angle = bearing.angle;
  message.density = bearing.density;
  message.range = bearing.range;
  message.near = bearing.near;
  message.state = static_cast<std::uint8_t>(bearing.state);
}

Bearing fromMessage(const ObstacleBearing& message) {
  return {message.angle, message.density, message.range, message.near,
          static_cast<BearingState>(message.state)};
}

template <class From, class To>
void toMessages(const std::vector<From>& from, std::vector<To>& to) {
  to.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) toMessage(from[i], to[i]);
}

template <class From, class To>
void fromMessages(const std::vector<From>& from, std::vector<To>& to) {
  to.clear();
  for (const From& each : from) to.push_back(fromMessage(each));
}

Refusal sameSize(const GrayView& picture, const ViewGeometry& view, const char* what) {
  if (picture.width == static_cast<int>(view.width) &&
      picture.height == static_cast<int>(view.height))
    return std::nullopt;
  return sentence(what, " is ", picture.width, "x", picture.height, ", but its view describes ",
                  view.width, "x", view.height);
}

}  // namespace

ros::Time rosTime(double seconds) {
  ros::Time stamp;
  if (seconds > 0.0 && seconds < 4294967295.0) stamp.fromSec(seconds);
  return stamp;
}

void toMessage(const GroundView& view, const FrameNames& frames, ViewGeometry& message) {
  const VanishingPoints points = vanishingPoints(view);
  message.reference_stamp = rosTime(view.reference_stamp);
  message.base_frame = frames.base;
  message.odom_frame = frames.odom;
  message.width = static_cast<std::uint32_t>(view.camera.width());
  message.height = static_cast<std::uint32_t>(view.camera.height());
  Eigen::Map<RowMajor>(message.K.data()) = view.camera.intrinsics().matrix();
  const Distortion& d = view.camera.distortion();
  message.D = {d.k1, d.k2, d.p1, d.p2, d.k3};
  Eigen::Map<PoseRows>(message.camera.data()) = view.T_base_camera.matrix().topRows<3>();
  message.pose = toMessage(view.T_odom_base);
  message.motion = toMessage(view.motion);
  Eigen::Map<RowMajor>(message.homography.data()) = view.G();
  Eigen::Map<Eigen::Vector3d>(message.vanishing_point_current.data()) = points.f1;
  Eigen::Map<Eigen::Vector3d>(message.vanishing_point_reference.data()) = points.f2;
}

Refusal fromMessage(const ViewGeometry& message, const ros::Time& stamp, GroundView& view) {
  if (Refusal refusal = cameraFromMessage(message, view)) return refusal;
  if (!allFinite(message.camera)) return sentence("view.camera is not finite");
  view.T_base_camera = CameraPose::Identity();
  view.T_base_camera.matrix().topRows<3>() = Eigen::Map<const PoseRows>(message.camera.data());
  if (auto error = checkCameraPose(view.T_base_camera)) return "view: " + *error;
  view.T_odom_base = fromMessage(message.pose);
  view.motion = fromMessage(message.motion);
  if (!view.T_odom_base.finite()) return sentence("view.pose is not finite");
  if (!view.motion.finite()) return sentence("view.motion is not finite");
  view.stamp = seconds(stamp);
  view.reference_stamp = seconds(message.reference_stamp);
  return std::nullopt;
}

Refusal wrap(const DifferenceImage& message, GrayView& difference, GrayView& valid) {
  if (Refusal refusal = wrapMono8(message.image, difference)) return refusal;
  if (Refusal refusal = wrapMono8(message.valid, valid)) return refusal;
  if (Refusal refusal = sameSize(difference, message.view, "difference image")) return refusal;
  return sameSize(valid, message.view, "valid image");
}

Refusal wrap(const ObstacleMask& message, GrayView& mask) {
  if (Refusal refusal = wrapMono8(message.mask, mask)) return refusal;
  return sameSize(mask, message.view, "mask");
}

void toMessage(const Obstacles& obstacles, const FrameNames& frames, ObstacleArray& message) {
  message.header.frame_id = frames.base;
  message.frame = obstacles.frame;
  toMessage(obstacles.view, frames, message.view);
  Eigen::Map<Eigen::Vector3d>(message.focus.data()) = obstacles.focus.f;
  message.max_range = obstacles.max_range;
  message.age = obstacles.age;
  message.separability = obstacles.separability;
  message.threshold = static_cast<std::int16_t>(obstacles.threshold);
  toMessages(obstacles.bearings, message.bearings);
  toMessages(obstacles.contacts, message.contacts);
  toMessages(obstacles.candidates, message.candidates);
}

Refusal fromMessage(const ObstacleArray& message, Obstacles& obstacles) {
  if (Refusal refusal = fromMessage(message.view, message.header.stamp, obstacles.view))
    return refusal;
  for (const ObstacleBearing& bearing : message.bearings)
    if (bearing.state > ObstacleBearing::BLOCKED)
      return sentence("bearing state ", int{bearing.state}, " does not exist");
  obstacles.frame = message.frame;
  obstacles.focus.f = Eigen::Map<const Eigen::Vector3d>(message.focus.data());
  obstacles.max_range = message.max_range;
  obstacles.age = message.age;
  obstacles.separability = message.separability;
  obstacles.threshold = message.threshold;
  fromMessages(message.bearings, obstacles.bearings);
  fromMessages(message.contacts, obstacles.contacts);
  fromMessages(message.candidates, obstacles.candidates);
  return std::nullopt;
}

}  // namespace ipm_mapping
