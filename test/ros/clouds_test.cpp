#include "ipm_mapping/ros/clouds.hpp"

#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <limits>

namespace ipm_mapping {
namespace {

std::vector<Eigen::Vector3f> pointsOf(const sensor_msgs::PointCloud2& cloud) {
  std::vector<Eigen::Vector3f> points;
  sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"), y(cloud, "y"), z(cloud, "z");
  for (; x != x.end(); ++x, ++y, ++z) points.emplace_back(*x, *y, *z);
  EXPECT_EQ(points.size(), std::size_t{cloud.width} * cloud.height);
  EXPECT_EQ(cloud.data.size(), std::size_t{cloud.row_step} * cloud.height);
  return points;
}

TEST(Clouds, EmptyCloudsStillHaveXYZ) {
  for (auto* make : {&toContactCloud, &toFreeCloud}) {
    sensor_msgs::PointCloud2 cloud;
    make(Obstacles{}, OutputParameters{}, cloud);
    ASSERT_GE(cloud.fields.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(cloud.fields[i].name, std::string(1, "xyz"[i]));
      EXPECT_EQ(cloud.fields[i].offset, 4 * i);
      EXPECT_EQ(cloud.fields[i].datatype, sensor_msgs::PointField::FLOAT32);
    }
    EXPECT_GE(cloud.point_step, 12U);
    EXPECT_TRUE(pointsOf(cloud).empty());
  }
}

TEST(Clouds, ContactsStandAtTheirHeightAndCarryTheirScore) {
  Obstacles o;
  o.contacts = {{0, 0, 0, {1.0F, 0.5F}, 12.0F, 0, 0, 0}, {1, 0, 0, {0.7F, -0.2F}, 9.0F, 0, 0, 0}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  o.contacts.push_back({2, 0, 0, {nan, 0.0F}, 1.0F, 0, 0, 0});
  OutputParameters p;
  p.contact_z = 0.25;
  sensor_msgs::PointCloud2 cloud;
  toContactCloud(o, p, cloud);
  const auto points = pointsOf(cloud);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0], Eigen::Vector3f(1.0F, 0.5F, 0.25F));
  EXPECT_EQ(points[1], Eigen::Vector3f(0.7F, -0.2F, 0.25F));
  sensor_msgs::PointCloud2ConstIterator<float> score(cloud, "intensity");
  EXPECT_EQ(*score, 12.0F);
  EXPECT_TRUE(cloud.is_dense);
}

TEST(Clouds, FreePointsLieWhereFloorWasSeenAndKeepOffObstacles) {
  Obstacles o;
  o.view.T_base_camera = cameraPose(0.2, -0.1, 0.45, 0.4);
  o.bearings = {{0.0F, 0, 1.5F, 0.4F, BearingState::Free},
                {0.3F, 0, 1.0F, 0.4F, BearingState::Occupied},
                {-0.3F, 0, 0.8F, 0.4F, BearingState::Blocked},
                {0.6F, 0, 1.9F, 0.4F, BearingState::Unknown}};
  OutputParameters p;
  p.free_step = 0.1;
  sensor_msgs::PointCloud2 cloud;
  toFreeCloud(o, p, cloud);
  int per_bearing[4] = {};
  const Eigen::Vector2f foot = o.view.cameraFoot().cast<float>();
  for (const auto& point : pointsOf(cloud)) {
    EXPECT_FLOAT_EQ(point.z(), 0.1F);
    const Eigen::Vector2f d = point.head<2>() - foot;
    for (int i = 0; i < 4; ++i) {
      const Bearing& b = o.bearings[static_cast<std::size_t>(i)];
      if (std::abs(std::atan2(d.y(), d.x()) - b.angle) > 1e-4F) continue;
      ++per_bearing[i];
      EXPECT_GT(d.norm(), b.near);
      const float keep = b.state == BearingState::Free ? 0.0F : 0.1F;
      EXPECT_LE(d.norm(), b.range - keep + 1e-5F);
    }
  }
  EXPECT_NEAR(per_bearing[0], 11, 1);
  EXPECT_NEAR(per_bearing[1], 5, 1);
  EXPECT_NEAR(per_bearing[2], 3, 1);
  EXPECT_EQ(per_bearing[3], 0);
}

TEST(Clouds, EndlessRangesDoNotMakeEndlessClouds) {
  Obstacles o;
  const float inf = std::numeric_limits<float>::infinity();
  o.bearings = {{0.0F, 0, inf, 0.4F, BearingState::Free}};
  sensor_msgs::PointCloud2 cloud;
  toFreeCloud(o, {}, cloud);
  EXPECT_TRUE(pointsOf(cloud).empty());
}

}  // namespace
}  // namespace ipm_mapping
