// A robot that drives, with wheels that count too much, and then stands and looks on: what it sees
// stays on the topics, as does somebody who comes for a while, the map stays as it is, and
// odom_refined knows better than the wheels.

#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>

#include "chain_client.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

constexpr double wheel_scale = 1.04;
constexpr int driving = 16, standing = 21;  // frames
constexpr int comes = driving + 6, leaves = comes + 8;

class Standing : public testing::Test {
 protected:
  /// The whole sequence once; the tests look at what came out.
  static void SetUpTestSuite() {
    node = std::make_unique<ros::NodeHandle>();
    obstacles = std::make_unique<Collected<ObstacleArray>>(*node, "/camera/obstacles");
    scans = std::make_unique<Collected<sensor_msgs::LaserScan>>(*node, "/camera/scan");
    contacts = std::make_unique<Collected<sensor_msgs::PointCloud2>>(*node, "/camera/contacts");
    maps = std::make_unique<Collected<nav_msgs::OccupancyGrid>>(*node, "/camera/map");
    updates =
        std::make_unique<Collected<map_msgs::OccupancyGridUpdate>>(*node, "/camera/map_updates");
    refined = std::make_unique<Collected<nav_msgs::Odometry>>(*node, "/camera/odom_refined");
    diagnostics = std::make_unique<Diagnostics>(*node);
    topics = std::make_unique<RobotTopics>(*node);
    whole = play();
  }
  /// A failure up there would skip every test, and a skipped test counts as passed.
  void SetUp() override { ASSERT_TRUE(whole) << refined->size() << " poses"; }

  static bool play() {
    topics->tellTf();
    const bool awake =
        waitForPublishers(*obstacles, *scans, *contacts, *maps, *updates, *refined) &&
        waitFor([] { return maps->size() > 0; }) && topics->waitForListeners();
    if (!awake) return false;
    for (int i = 0; i < driving + standing; ++i) {
      const double t = topics->robot.frameTime(i);
      topics->sendInfo(t);
      topics->sendImage(topics->robot.image(topics->stamp(t), truth(i), i >= comes && i < leaves));
      for (int k = 0; k < 5; ++k) sendWheels(i, k);
      ros::spinOnce();
    }
    sendWheels(driving + standing, 0);
    const bool followed = waitFor([] { return refined->size() == driving + standing; });
    waitFor(
        [] {
          return !obstacles->all.empty() && frameOf(obstacles->last()) == driving + standing - 1 &&
                 scans->size() == obstacles->size() && contacts->size() == scans->size();
        },
        10.0);
    return followed;
  }
  static void TearDownTestSuite() {
    obstacles.reset(), scans.reset(), contacts.reset(), maps.reset(), updates.reset();
    refined.reset(), diagnostics.reset(), topics.reset(), node.reset();
  }

  static int frameOf(const ObstacleArray& answer) { return static_cast<int>(answer.frame); }
  /// From frame `driving` - 1 on the robot stands.
  static SE2 truth(int frame, double later = 0.0) {
    const double last = topics->robot.frameTime(driving - 1);
    return topics->robot.pose(std::min(topics->robot.frameTime(frame) + later, last));
  }
  static void sendWheels(int frame, int k) {
    const double later = k * topics->robot.odometry_period;
    SE2 pose = truth(frame, later);
    pose.x *= wheel_scale;
    pose.y *= wheel_scale;
    topics->sendOdometry(
        topics->robot.odometry(topics->stamp(topics->robot.frameTime(frame) + later), pose));
  }
  static std::vector<const ObstacleArray*> answers(bool remembered) {
    std::vector<const ObstacleArray*> chosen;
    for (const auto& each : obstacles->all)
      if ((each->age > 0.0F) == remembered) chosen.push_back(each.get());
    return chosen;
  }

  static bool whole;
  static std::unique_ptr<ros::NodeHandle> node;
  static std::unique_ptr<Collected<ObstacleArray>> obstacles;
  static std::unique_ptr<Collected<sensor_msgs::LaserScan>> scans;
  static std::unique_ptr<Collected<sensor_msgs::PointCloud2>> contacts;
  static std::unique_ptr<Collected<nav_msgs::OccupancyGrid>> maps;
  static std::unique_ptr<Collected<map_msgs::OccupancyGridUpdate>> updates;
  static std::unique_ptr<Collected<nav_msgs::Odometry>> refined;
  static std::unique_ptr<Diagnostics> diagnostics;
  static std::unique_ptr<RobotTopics> topics;
};
bool Standing::whole = false;
std::unique_ptr<ros::NodeHandle> Standing::node;
std::unique_ptr<Collected<ObstacleArray>> Standing::obstacles;
std::unique_ptr<Collected<sensor_msgs::LaserScan>> Standing::scans;
std::unique_ptr<Collected<sensor_msgs::PointCloud2>> Standing::contacts;
std::unique_ptr<Collected<nav_msgs::OccupancyGrid>> Standing::maps;
std::unique_ptr<Collected<map_msgs::OccupancyGridUpdate>> Standing::updates;
std::unique_ptr<Collected<nav_msgs::Odometry>> Standing::refined;
std::unique_ptr<Diagnostics> Standing::diagnostics;
std::unique_ptr<RobotTopics> Standing::topics;

TEST_F(Standing, EveryStandingFrameTellsWhatItSeesAndSinceWhenThatIsNothingNew) {
  const auto fresh = answers(false), held = answers(true);
  ASSERT_GT(fresh.size(), 8U);
  ASSERT_EQ(held.size(), std::size_t{standing});
  const ObstacleArray& last = *fresh.back();
  ASSERT_FALSE(last.contacts.empty()) << "the drive has to end in front of something";
  float age = 0.0F;
  for (const ObstacleArray* answer : held) {
    EXPECT_GT(answer->age, age);
    age = answer->age;
    EXPECT_NEAR(age, (answer->header.stamp - last.header.stamp).toSec(), 1e-3);
    ASSERT_GE(answer->contacts.size(), last.contacts.size());
    for (const ObstacleContact& contact : answer->contacts) {
      EXPECT_GT(contact.age, 0.0F);
      EXPECT_LT(contact.age, age + 1.0F);
    }
    for (const ObstacleContact& seen : last.contacts)
      EXPECT_TRUE(std::any_of(answer->contacts.begin(), answer->contacts.end(),
                              [&](const ObstacleContact& c) {
                                return std::hypot(c.x - seen.x, c.y - seen.y) < 0.02F;
                              }));
  }
  for (const ObstacleArray* answer : fresh)
    for (const ObstacleContact& contact : answer->contacts) EXPECT_EQ(contact.age, 0.0F);
}

TEST_F(Standing, SeesSomebodyComeAndLeave) {
  const SyntheticRobot::Box visitor = SyntheticRobot::visitor();
  const SE2 pose = truth(driving);
  const auto off = [&](const Eigen::Vector2d& p_base) {
    const Eigen::Vector2d p = pose * p_base;
    return (p - p.cwiseMax(visitor.low.head<2>()).cwiseMin(visitor.high.head<2>())).norm();
  };
  const Eigen::Vector2d middle =
      pose.inverse() * Eigen::Vector2d(0.5 * (visitor.low + visitor.high).head<2>());
  for (std::size_t i = 0; i < obstacles->size(); ++i) {
    const ObstacleArray& answer = *obstacles->all[i];
    const int frame = frameOf(answer);
    if (frame < driving) continue;
    const auto there = std::count_if(answer.contacts.begin(), answer.contacts.end(),
                                     [&](const ObstacleContact& c) {
                                       return c.moving && off({c.x, c.y}) < 0.06;
                                     });
    int cloud = 0;
    for (sensor_msgs::PointCloud2ConstIterator<float> p(*contacts->all[i], "x"); p != p.end(); ++p)
      cloud += off({p[0], p[1]}) < 0.06 ? 1 : 0;
    const sensor_msgs::LaserScan& scan = *scans->all[i];
    const auto ray = static_cast<std::size_t>(
        std::lround((std::atan2(middle.y(), middle.x()) - scan.angle_min) / scan.angle_increment));
    if (frame > comes && frame < leaves) {
      EXPECT_GE(there, 2) << frame;
      EXPECT_GE(cloud, 2) << frame;
      EXPECT_NEAR(scan.ranges.at(ray), middle.norm(), 0.15) << frame;
    } else if (frame != comes) {
      EXPECT_EQ(there, 0) << frame;
      EXPECT_EQ(cloud, 0) << frame;
      EXPECT_GT(scan.ranges.at(ray), middle.norm() + 0.2) << frame << ": the way is free";
    }
  }
}

TEST_F(Standing, ScanAndContactsDoNotGoEmpty) {
  ASSERT_EQ(scans->size(), obstacles->size());
  ASSERT_EQ(contacts->size(), obstacles->size());
  for (std::size_t i = 0; i < obstacles->size(); ++i) {
    const ObstacleArray& answer = *obstacles->all[i];
    EXPECT_EQ(contacts->all[i]->width, answer.contacts.size());
    if (!(answer.age > 0.0F)) continue;
    const auto& ranges = scans->all[i]->ranges;
    EXPECT_GT(std::count_if(ranges.begin(), ranges.end(), [](float r) { return std::isfinite(r); }),
              0);
  }
}

TEST_F(Standing, IsNotCountedAsUsed) {
  EXPECT_TRUE(diagnostics->waitFor("detector", "skipped_no_motion", 2));  // not sure yet
  const double used = static_cast<double>(answers(false).size());
  EXPECT_TRUE(diagnostics->waitFor("detector", "watched", standing - 2));
  EXPECT_TRUE(diagnostics->waitFor("detector", "used", used));
  EXPECT_TRUE(diagnostics->waitFor("mapper", "skipped_remembered", standing));
  EXPECT_TRUE(diagnostics->waitFor("mapper", "used", used));
}

TEST_F(Standing, TheMapEndsWithTheDrive) {
  const ros::Time end = answers(false).back()->header.stamp;
  ASSERT_TRUE(waitFor([&] { return maps->last().header.stamp == end; }));
  const auto cells = maps->last().data;
  EXPECT_GT(std::count(cells.begin(), cells.end(), 0), 100) << "the drive has to show something";
  waitFor([] { return false; }, 1.5);  // longer than full_map_period
  EXPECT_EQ(maps->last().data, cells);
  // The first map, of before the drive, is stamped with the time of its making.
  for (std::size_t i = 1; i < maps->size(); ++i) EXPECT_LE(maps->all[i]->header.stamp, end);
  for (const auto& update : updates->all) EXPECT_LE(update->header.stamp, end);
}

TEST_F(Standing, OdomRefinedIsNearerToTheTruthThanTheWheels) {
  const SE2 there = truth(driving), got = toSE2(refined->last().pose.pose);
  const double wheels = (wheel_scale - 1.0) * there.distance();
  ASSERT_GT(wheels, 0.025);
  EXPECT_LT(std::hypot(got.x - there.x, got.y - there.y), 0.4 * wheels);
  EXPECT_NEAR(got.theta, there.theta, 0.01);
  const nav_msgs::Odometry& moving = *refined->all[driving - 5];
  EXPECT_NEAR(moving.twist.twist.linear.x, 0.53, 0.02) << "wheels: " << 0.53 * wheel_scale;
  EXPECT_NEAR(refined->last().twist.twist.linear.x, 0.0, 1e-3);
}

TEST_F(Standing, OdomRefinedHasFramesStampsAndACovarianceThatHoldsTheError) {
  ASSERT_EQ(refined->size(), std::size_t{driving + standing});
  using Full = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  double before = 0.0;
  for (std::size_t i = 0; i < refined->size(); ++i) {
    const nav_msgs::Odometry& message = *refined->all[i];
    EXPECT_EQ(message.header.frame_id, topics->robot.odom_frame);
    EXPECT_EQ(message.child_frame_id, topics->robot.base_frame);
    EXPECT_NEAR(message.header.stamp.toSec(),
                topics->stamp(topics->robot.frameTime(static_cast<int>(i))), 1e-6);
    const Eigen::Map<const Full> covariance(message.pose.covariance.data());
    EXPECT_GT(covariance.determinant(), 0.0);
    const SE2 there = truth(static_cast<int>(i)), got = toSE2(message.pose.pose);
    EXPECT_LT(std::abs(got.x - there.x), 4.0 * std::sqrt(covariance(0, 0))) << i;
    EXPECT_LT(std::abs(got.y - there.y), 4.0 * std::sqrt(covariance(1, 1))) << i;
    EXPECT_LT(covariance(0, 0), 0.05 * 0.05);
    if (i >= driving) {
      EXPECT_NEAR(covariance(0, 0), before, 1e-6) << "standing";
    }
    before = covariance(0, 0);
  }
}

TEST_F(Standing, AnswersArePlacedWhereThePosesParameterSays) {
  const auto poses =
      ros::param::param<std::string>("/camera/detector/floor_odometry/poses", "odometry");
  double apart = 0.0;
  for (const auto& answer : obstacles->all) {
    const auto same = std::find_if(refined->all.begin(), refined->all.end(), [&](const auto& pose) {
      return pose->header.stamp == answer->header.stamp;
    });
    ASSERT_NE(same, refined->all.end());
    const SE2 floor = toSE2((*same)->pose.pose);
    SE2 wheels = truth(frameOf(*answer));
    wheels.x *= wheel_scale;
    wheels.y *= wheel_scale;
    const SE2& expected = poses == "refined" ? floor : wheels;
    EXPECT_NEAR(answer->view.pose.x, expected.x, 1e-4);
    EXPECT_NEAR(answer->view.pose.y, expected.y, 1e-4);
    EXPECT_NEAR(answer->view.pose.theta, expected.theta, 1e-4);
    apart = std::max(apart, std::hypot(floor.x - wheels.x, floor.y - wheels.y));
  }
  EXPECT_GT(apart, 0.01) << "the two have to differ for this to say something";
}

/// Last: it adds a frame to what the others look at.
TEST_F(Standing, AnotherHeightOfThePointsOrARefusedChangeForgetsNothing) {
  dynamic_reconfigure::Reconfigure height, refused;
  height.request.config.doubles.resize(1);
  height.request.config.doubles[0].name = "output/contact_z";
  height.request.config.doubles[0].value = 0.15;
  refused.request.config.doubles.resize(1);
  refused.request.config.doubles[0].name = "map/hit";  // not one of those that change live
  refused.request.config.doubles[0].value = 0.5;
  for (auto* call : {&height, &refused})
    ASSERT_TRUE(ros::service::call("/camera/detector/set_parameters", *call));
  const std::size_t before = obstacles->size();
  const int frame = driving + standing;
  const double t = topics->robot.frameTime(frame);
  topics->sendInfo(t);
  topics->sendImage(topics->robot.image(topics->stamp(t), truth(frame)));
  for (int k = 1; k <= 5; ++k) sendWheels(frame, k);
  ASSERT_TRUE(waitFor([&] { return obstacles->size() > before && contacts->size() > before; }));
  EXPECT_GT(obstacles->last().age, 0.0F);
  EXPECT_FALSE(obstacles->last().contacts.empty());
  const sensor_msgs::PointCloud2ConstIterator<float> z(contacts->last(), "z");
  EXPECT_FLOAT_EQ(*z, 0.15F);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "standing_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
