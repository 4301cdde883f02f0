// The chain, of either architecture, as launch/chain.launch starts it, seen from outside: the same
// answers and the same map as the classes give in one piece, and topics that follow the rules of
// their consumers.

#include <gtest/gtest.h>
#include <ipm_mapping/SaveMap.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <std_srvs/Trigger.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "chain_client.hpp"
#include "ipm_mapping/detectors/chain_detector.hpp"
#include "ipm_mapping/frame_gate.hpp"
#include "ipm_mapping/mapping/map_io.hpp"
#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "ipm_mapping/ros/poses.hpp"

namespace ipm_mapping {
namespace {

/// The same sequence through the core, in this process.
struct Reference {
  std::vector<Obstacles> answers;
  std::unique_ptr<OccupancyMap> map;

  explicit Reference(const SyntheticRobot& robot) {
    Parameters parameters =
        Parameters::profile(ros::param::param<std::string>("~profile", "default"));
    parameters.map.hit = 3.0;  // these two as in the .test file
    parameters.map.update = MapUpdate::LogOdds;
    ChainDetector detector(parameters);
    detector.setCamera(CameraModel(robot.intrinsics(), {}),
                       tf2::transformToEigen(robot.cameraTransform()));
    map = std::make_unique<OccupancyMap>(parameters.map);
    FrameGate<sensor_msgs::ImagePtr> gate(parameters.odometry, 1000);
    const auto stamp = [&](double t) { return ros::Time(robot.first_stamp + t).toSec(); };
    for (int k = 0; k <= 5 * robot.frames; ++k) {
      const double t = robot.odometryTime(k);
      if (k % 5 == 0 && k < 5 * robot.frames)
        gate.addFrame(stamp(t), robot.image(robot.first_stamp + t, robot.pose(t)));
      gate.addOdometry(stamp(t), toSE2(robot.odometry(0, robot.pose(t)).pose.pose));
    }
    FrameGate<sensor_msgs::ImagePtr>::Released frame;
    for (std::uint64_t index = 0; gate.next(frame); ++index) {
      Obstacles answer;
      const GrayView view(frame.payload->data.data(), robot.width, robot.height);
      if (detector.process({index, frame.stamp, view, frame.T_odom_base}, answer) !=
          FrameStatus::Used)
        continue;
      map->update(answer);
      answers.push_back(answer);
    }
  }
};

class Chain : public testing::Test {
 protected:
  /// Plays the whole sequence once; the tests look at what came out.
  static void SetUpTestSuite() { played = play(); }
  /// What fails for the whole suite only skips its tests, and rostest calls them passed.
  void SetUp() override { ASSERT_TRUE(played); }

  static bool play() {
    node = std::make_unique<ros::NodeHandle>();
    maps = std::make_unique<Collected<nav_msgs::OccupancyGrid>>(*node, "/camera/map");
    probabilities =
        std::make_unique<Collected<nav_msgs::OccupancyGrid>>(*node, "/camera/map_probability");
    updates =
        std::make_unique<Collected<map_msgs::OccupancyGridUpdate>>(*node, "/camera/map_updates");
    obstacles = std::make_unique<Collected<ObstacleArray>>(*node, "/camera/obstacles");
    scans = std::make_unique<Collected<sensor_msgs::LaserScan>>(*node, "/camera/scan");
    contacts = std::make_unique<Collected<sensor_msgs::PointCloud2>>(*node, "/camera/contacts");
    free_floor = std::make_unique<Collected<sensor_msgs::PointCloud2>>(*node, "/camera/free");
    topics = std::make_unique<RobotTopics>(*node);
    reference = std::make_unique<Reference>(topics->robot);
    if (!waitFor([] { return maps->size() > 0; })) return false;
    first_map = maps->all.front();
    topics->tellTf();
    if (!waitForPublishers(*maps, *probabilities, *updates, *obstacles, *scans, *contacts,
                           *free_floor) ||
        !topics->waitForListeners())
      return false;
    // a whole map half way: the rest comes as updates first
    const int half = topics->robot.frames - topics->robot.frames / 3;
    topics->play(0, half);
    waitFor([] {
      return !obstacles->all.empty() && maps->last().header.stamp == obstacles->last().header.stamp;
    });
    topics->play(half, topics->robot.frames);
    waitFor([] {
      return obstacles->size() >= reference->answers.size() && scans->size() >= obstacles->size() &&
             contacts->size() >= obstacles->size() && free_floor->size() >= obstacles->size();
    });
    waitFor([] { return maps->last().header.stamp == obstacles->last().header.stamp; });
    return true;
  }
  static void TearDownTestSuite() {
    maps.reset(), probabilities.reset(), updates.reset(), obstacles.reset(), scans.reset();
    contacts.reset(), free_floor.reset(), topics.reset(), reference.reset(), node.reset();
  }
  /// Half a metre around the robot at the map's stamp lies inside.
  static void expectRobotIn(const nav_msgs::OccupancyGrid& map) {
    for (const auto& answer : obstacles->all) {
      if (answer->header.stamp != map.header.stamp) continue;
      const auto& robot = answer->view.pose;
      const auto& origin = map.info.origin.position;
      EXPECT_LE(origin.x, robot.x - 0.5);
      EXPECT_LE(origin.y, robot.y - 0.5);
      EXPECT_GE(origin.x + map.info.width * static_cast<double>(map.info.resolution),
                robot.x + 0.5);
      EXPECT_GE(origin.y + map.info.height * static_cast<double>(map.info.resolution),
                robot.y + 0.5);
      return;
    }
    ADD_FAILURE() << "no answer has the map's stamp";
  }

  static std::unique_ptr<ros::NodeHandle> node;
  static std::unique_ptr<Collected<nav_msgs::OccupancyGrid>> maps, probabilities;
  static std::unique_ptr<Collected<map_msgs::OccupancyGridUpdate>> updates;
  static std::unique_ptr<Collected<ObstacleArray>> obstacles;
  static std::unique_ptr<Collected<sensor_msgs::LaserScan>> scans;
  static std::unique_ptr<Collected<sensor_msgs::PointCloud2>> contacts, free_floor;
  static std::unique_ptr<RobotTopics> topics;
  static std::unique_ptr<Reference> reference;
  static bool played;
  static nav_msgs::OccupancyGridConstPtr first_map;
};
std::unique_ptr<ros::NodeHandle> Chain::node;
std::unique_ptr<Collected<nav_msgs::OccupancyGrid>> Chain::maps, Chain::probabilities;
std::unique_ptr<Collected<map_msgs::OccupancyGridUpdate>> Chain::updates;
std::unique_ptr<Collected<ObstacleArray>> Chain::obstacles;
std::unique_ptr<Collected<sensor_msgs::LaserScan>> Chain::scans;
std::unique_ptr<Collected<sensor_msgs::PointCloud2>> Chain::contacts, Chain::free_floor;
std::unique_ptr<RobotTopics> Chain::topics;
std::unique_ptr<Reference> Chain::reference;
bool Chain::played = false;
nav_msgs::OccupancyGridConstPtr Chain::first_map;

TEST_F(Chain, EveryMapHoldsTheRobot) {
  ASSERT_GT(maps->size(), 1U);
  for (std::size_t i = 1; i < maps->size(); ++i) expectRobotIn(*maps->all[i]);
}

TEST_F(Chain, PublishesAnUnknownMapBeforeAnythingWasSeen) {
  EXPECT_EQ(first_map->header.frame_id, "odom");
  ASSERT_FALSE(first_map->data.empty());
  for (std::int8_t cell : first_map->data) ASSERT_EQ(cell, -1);
}

TEST_F(Chain, AnswersWhatTheClassesAnswerInOnePiece) {
  ASSERT_EQ(obstacles->size(), reference->answers.size());
  for (std::size_t i = 0; i < obstacles->size(); ++i) {
    const ObstacleArray& got = *obstacles->all[i];
    const Obstacles& expected = reference->answers[i];
    EXPECT_EQ(got.frame, expected.frame);
    EXPECT_EQ(got.threshold, expected.threshold);
    ASSERT_EQ(got.bearings.size(), expected.bearings.size());
    for (std::size_t k = 0; k < got.bearings.size(); ++k) {
      ASSERT_EQ(int{got.bearings[k].state}, static_cast<int>(expected.bearings[k].state));
      ASSERT_EQ(got.bearings[k].range, expected.bearings[k].range) << "frame " << got.frame;
    }
    ASSERT_EQ(got.contacts.size(), expected.contacts.size());
    for (std::size_t k = 0; k < got.contacts.size(); ++k) {
      ASSERT_EQ(got.contacts[k].x, expected.contacts[k].p_base.x());
      ASSERT_EQ(got.contacts[k].y, expected.contacts[k].p_base.y());
    }
  }
}

TEST_F(Chain, BuildsTheSameMapCellForCell) {
  const nav_msgs::OccupancyGrid& got = maps->last();
  const MapGeometry& geometry = reference->map->geometry();
  ASSERT_EQ(got.info.width, static_cast<std::uint32_t>(geometry.width));
  ASSERT_EQ(got.info.height, static_cast<std::uint32_t>(geometry.height));
  EXPECT_EQ(got.info.origin.position.x, geometry.originX());
  EXPECT_EQ(got.info.origin.position.y, geometry.originY());
  EXPECT_FLOAT_EQ(got.info.resolution, static_cast<float>(geometry.resolution));
  int free = 0, occupied = 0;
  for (std::size_t i = 0; i < got.data.size(); ++i) {
    ASSERT_EQ(got.data[i], reference->map->occupancy(i)) << "cell " << i;
    free += got.data[i] == 0;
    occupied += got.data[i] == 100;
  }
  EXPECT_GT(free, 500) << "the sequence has to show something";
  EXPECT_GT(occupied, 0);
}

TEST_F(Chain, MapIsTrinaryAndProbabilitiesGoElsewhere) {
  for (const auto& map : maps->all)
    for (std::int8_t cell : map->data) ASSERT_TRUE(cell == -1 || cell == 0 || cell == 100);
  ASSERT_GT(probabilities->size(), 0U);
  const auto& shares = probabilities->last();
  int between = 0;
  for (std::size_t i = 0; i < shares.data.size(); ++i) {
    ASSERT_TRUE(shares.data[i] >= -1 && shares.data[i] <= 100);
    between += shares.data[i] > 0 && shares.data[i] < 100;
  }
  EXPECT_GT(between, 0);
}

TEST_F(Chain, UpdatesStayInsideTheGeometryOfTheMapBefore) {
  ASSERT_GT(updates->size(), 0U);
  // A consumer that applies updates to the last whole map, in the order of the stamps.
  for (const auto& update : updates->all) {
    nav_msgs::OccupancyGridConstPtr base;
    for (const auto& map : maps->all)
      if (map->header.stamp <= update->header.stamp) base = map;
    ASSERT_TRUE(base);
    EXPECT_EQ(update->header.frame_id, base->header.frame_id);
    ASSERT_EQ(update->data.size(), std::size_t{update->width} * update->height);
    EXPECT_GE(update->x, 0);
    EXPECT_GE(update->y, 0);
    EXPECT_LE(update->x + update->width, base->info.width);
    EXPECT_LE(update->y + update->height, base->info.height);
  }
}

TEST_F(Chain, AWholeMapIsTheOneBeforeWithTheUpdatesInBetween) {
  int compared = 0;
  for (std::size_t i = 1; i < maps->size(); ++i) {
    nav_msgs::OccupancyGrid patched = *maps->all[i - 1];
    const nav_msgs::OccupancyGrid& next = *maps->all[i];
    if (patched.info.width != next.info.width || patched.info.height != next.info.height ||
        patched.info.origin.position.x != next.info.origin.position.x ||
        patched.info.origin.position.y != next.info.origin.position.y)
      continue;
    int patches = 0;
    for (const auto& update : updates->all) {
      if (update->header.stamp <= patched.header.stamp || update->header.stamp > next.header.stamp)
        continue;
      for (std::size_t k = 0; k < update->data.size(); ++k) {
        const std::size_t x = static_cast<std::size_t>(update->x) + k % update->width;
        const std::size_t y = static_cast<std::size_t>(update->y) + k / update->width;
        patched.data[y * patched.info.width + x] = update->data[k];
      }
      ++patches;
    }
    EXPECT_EQ(patched.data, next.data) << "map " << i;
    compared += patches > 0;
  }
  EXPECT_GT(compared, 0);
}

TEST_F(Chain, LateSubscriberGetsThePresentMap) {
  Collected<nav_msgs::OccupancyGrid> late(*node, "/camera/map");
  ASSERT_TRUE(waitFor([&] { return late.size() > 0; }));
  EXPECT_EQ(late.last().data, maps->last().data);
  EXPECT_EQ(late.last().header.stamp, maps->last().header.stamp);
}

TEST_F(Chain, EverythingCarriesTheStampOfTheImageAndTheRobotsFrame) {
  ASSERT_EQ(scans->size(), obstacles->size());
  for (std::size_t i = 0; i < obstacles->size(); ++i) {
    const ros::Time stamp = obstacles->all[i]->header.stamp;
    ros::Time image;
    image.fromSec(
        topics->stamp(topics->robot.frameTime(static_cast<int>(obstacles->all[i]->frame))));
    EXPECT_EQ(stamp, image);
    for (const std_msgs::Header& header :
         {scans->all[i]->header, contacts->all[i]->header, free_floor->all[i]->header}) {
      EXPECT_EQ(header.stamp, stamp);
      EXPECT_EQ(header.frame_id, topics->robot.base_frame);
    }
  }
}

TEST_F(Chain, ScanKeepsToRep117) {
  int infinite = 0, finite = 0;
  for (const auto& scan : scans->all) {
    ASSERT_FALSE(scan->ranges.empty());
    EXPECT_GT(scan->range_min, 0.0F);
    EXPECT_NEAR(
        scan->angle_max,
        scan->angle_min + scan->angle_increment * static_cast<float>(scan->ranges.size() - 1),
        1e-5);
    for (float range : scan->ranges) {
      infinite += std::isinf(range);
      if (std::isnan(range) || std::isinf(range)) {
        EXPECT_FALSE(std::isinf(range) && range < 0);
        continue;
      }
      ++finite;
      EXPECT_GT(range, scan->range_min);
      EXPECT_LT(range, scan->range_max);
    }
  }
  EXPECT_GT(infinite, 0);
  EXPECT_GT(finite, 0);
}

TEST_F(Chain, CloudsAreWhatAnObstacleLayerKeeps) {
  std::size_t points = 0;
  for (const auto* clouds : {contacts.get(), free_floor.get()})
    for (const auto& cloud : clouds->all) {
      sensor_msgs::PointCloud2ConstIterator<float> x(*cloud, "x"), y(*cloud, "y"), z(*cloud, "z");
      for (; z != z.end(); ++x, ++y, ++z, ++points) {
        // costmap_2d's defaults: min_obstacle_height 0.0, max_obstacle_height 2.0.
        EXPECT_GT(*z, 0.0F);
        EXPECT_LT(*z, 2.0F);
        EXPECT_LT(std::hypot(*x, *y), 20.0F);
      }
    }
  EXPECT_GT(points, 0U);
}

TEST_F(Chain, ServicesSaveTheMapBelowTheirFolderOnlyAndResetIt) {
  const auto directory = ros::param::param<std::string>("~directory", "");
  ASSERT_FALSE(directory.empty());
  const auto save = [](const std::string& name) {
    SaveMap call;
    call.request.name = name;
    EXPECT_TRUE(ros::service::call("/camera/save_map", call));
    return call.response;
  };
  for (const char* name : {"/tmp/ipm_mapping_escape", "../ipm_mapping_escape", "a/../../b"}) {
    EXPECT_FALSE(save(name).success) << name;
    EXPECT_FALSE(std::filesystem::exists("/tmp/ipm_mapping_escape.pgm"));
  }
  const auto saved = save("sub/kitchen");
  ASSERT_TRUE(saved.success) << saved.message;
  EXPECT_EQ(saved.message, directory + "/sub/kitchen.yaml");
  TrinaryMap map;
  ASSERT_EQ(loadMap(saved.message, map), std::nullopt);
  EXPECT_EQ(map.cells, maps->last().data);
  std::filesystem::remove_all(directory);

  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("/camera/reset_map", reset));
  EXPECT_TRUE(reset.response.success);
  const std::size_t before = maps->size();
  ASSERT_TRUE(waitFor([&] {
    return maps->size() > before ||
           std::count(maps->last().data.begin(), maps->last().data.end(), -1) ==
               static_cast<std::ptrdiff_t>(maps->last().data.size());
  }));
  for (std::int8_t cell : maps->last().data) ASSERT_EQ(cell, -1);
  expectRobotIn(maps->last());
  EXPECT_FALSE(save("empty").success);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "chain_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
