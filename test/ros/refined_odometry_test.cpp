#include "ipm_mapping/ros/refined_odometry.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

sweep::FloorPose somewhere() {
  sweep::FloorPose pose;
  pose.T_odom_base = {1.5, -2.5, 2.0};
  pose.covariance << 4e-4, 1e-5, 2e-5, 1e-5, 9e-4, 3e-5, 2e-5, 3e-5, 1e-4;
  pose.velocity = {0.3, -0.01, 0.2};
  pose.velocity_covariance << 1e-4, 1e-6, 2e-6, 1e-6, 2e-4, 3e-6, 2e-6, 3e-6, 3e-4;
  return pose;
}

nav_msgs::Odometry messageOf(const sweep::FloorPose& pose) {
  nav_msgs::Odometry message;
  message.pose.covariance.assign(77.0);  // what was there before must not shine through
  toMessage(pose, {"base_footprint", "odom"}, message);
  return message;
}

TEST(RefinedOdometryMessage, HasPoseInOdomAndVelocityInBase) {
  const nav_msgs::Odometry message = messageOf(somewhere());
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_footprint");
  const SE2 pose = toSE2(message.pose.pose);
  EXPECT_DOUBLE_EQ(pose.x, 1.5);
  EXPECT_DOUBLE_EQ(pose.y, -2.5);
  EXPECT_NEAR(pose.theta, 2.0, 1e-12);
  EXPECT_EQ(message.pose.pose.position.z, 0.0);
  EXPECT_EQ(message.twist.twist.linear.x, 0.3);
  EXPECT_EQ(message.twist.twist.linear.y, -0.01);
  EXPECT_EQ(message.twist.twist.angular.z, 0.2);
}

TEST(RefinedOdometryMessage, CovarianceOfHeadingStandsUnderYaw) {
  const nav_msgs::Odometry message = messageOf(somewhere());
  using Full = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  const Eigen::Map<const Full> pose(message.pose.covariance.data());
  const Eigen::Map<const Full> twist(message.twist.covariance.data());
  EXPECT_TRUE(pose.isApprox(pose.transpose()));
  EXPECT_NEAR(pose(0, 0), 4e-4, 2e-6);
  EXPECT_DOUBLE_EQ(pose(0, 1), 1e-5);
  EXPECT_DOUBLE_EQ(pose(0, 5), 2e-5);
  EXPECT_DOUBLE_EQ(pose(5, 1), 3e-5);
  EXPECT_NEAR(pose(5, 5), 1e-4, 2e-6);
  EXPECT_NEAR(twist(5, 5), 3e-4, 2e-6);
  EXPECT_DOUBLE_EQ(pose.block(2, 0, 3, 2).norm() + pose.block(2, 5, 3, 1).norm(), 0.0);
  for (const auto& covariance : {Full(pose), Full(twist)})
    EXPECT_GT(covariance.determinant(), 0.0) << "filters invert it";
}

TEST(RefinedOdometryMessage, AtTheStartNothingIsSurerThanAMillimetre) {
  const nav_msgs::Odometry message = messageOf({});
  for (std::size_t i = 0; i < 6; ++i) EXPECT_GE(message.pose.covariance[7 * i], 1e-6);
}

}  // namespace
}  // namespace ipm_mapping
