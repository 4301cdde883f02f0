// Messages go from nodelet to nodelet as pointers: two listeners in the manager get one object, it
// travels over no socket, and nobody writes to it afterwards.

#include <gtest/gtest.h>
#include <ipm_mapping/DifferenceImage.h>
#include <ipm_mapping/ObstacleMask.h>
#include <nodelet/loader.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>

#include <thread>

#include "chain_client.hpp"

namespace ipm_mapping {
namespace {

template <class Message>
std::uint64_t checksum(const Message& message) {
  const std::uint32_t length = ros::serialization::serializationLength(message);
  std::vector<std::uint8_t> bytes(length);
  ros::serialization::OStream stream(bytes.data(), length);
  ros::serialization::serialize(stream, message);
  std::uint64_t sum = 1469598103934665603ULL;
  for (std::uint8_t byte : bytes) sum = (sum ^ byte) * 1099511628211ULL;
  return sum;
}

/// Two listeners of one topic, with a checksum taken when the first one got the message.
template <class Message>
struct Pair {
  Pair(ros::NodeHandle& node, const std::string& topic) : first(node, topic), second(node, topic) {
    witness = node.subscribe<Message>(topic, 1000,
                                      [this](const boost::shared_ptr<const Message>& message) {
                                        sums.push_back(checksum(*message));
                                      });
  }
  /// `seq`: what the publisher wrote into the header. roscpp counts there when it serialises.
  void expectSharedAndUntouched(std::uint32_t seq) const {
    ASSERT_EQ(first.size(), second.size());
    ASSERT_EQ(first.size(), sums.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first.all[i].get(), second.all[i].get()) << "message " << i << " was copied";
      EXPECT_EQ(first.all[i]->header.seq, seq) << "message " << i << " was serialised";
      EXPECT_EQ(checksum(*first.all[i]), sums[i]) << "message " << i << " was written to";
    }
  }
  Collected<Message> first, second;
  ros::Subscriber witness;
  std::vector<std::uint64_t> sums;
};

/// Transports over which this process gets a topic, as rosnode info shows them.
std::vector<std::string> transportsOf(const std::string& topic) {
  XmlRpc::XmlRpcValue arguments, answer, payload;
  arguments[0] = ros::this_node::getName();
  XmlRpc::XmlRpcClient client(ros::network::getHost().c_str(),
                              static_cast<int>(ros::XMLRPCManager::instance()->getServerPort()));
  std::vector<std::string> transports;
  if (!client.execute("getBusInfo", arguments, answer)) return transports;
  for (int i = 0; i < answer[2].size(); ++i)
    if (std::string(answer[2][i][4]) == topic) transports.push_back(answer[2][i][3]);
  return transports;
}

TEST(ZeroCopy, EveryLinkOfTheChainSharesItsMessages) {
  ros::NodeHandle node;
  RobotTopics topics(node);
  nodelet::Loader loader(false);
  const nodelet::M_string robot{{ros::names::resolve("image_raw"), "/robot/image_raw"},
                                {ros::names::resolve("camera_info"), "/robot/camera_info"},
                                {ros::names::resolve("odom"), "/robot/odom"}};
  // The sequence comes in one burst: nothing may be dropped for that.
  ros::param::set("/ipm/queue", 1000);
  ros::param::set("/ipm/waiting_frames", 1000);
  ros::param::set("/ipm/odometry/wait", 60.0);
  ASSERT_TRUE(loader.load("/ipm", "ipm_mapping/Ipm", robot, {}));
  ASSERT_TRUE(loader.load("/segmentation", "ipm_mapping/Segmentation", {}, {}));
  ASSERT_TRUE(loader.load("/localization", "ipm_mapping/Localization", {}, {}));
  ASSERT_TRUE(loader.load("/mapper", "ipm_mapping/Mapper", {}, {}));

  Pair<DifferenceImage> differences(node, "/difference");
  Pair<ObstacleMask> masks(node, "/mask");
  Pair<ObstacleArray> obstacles(node, "/obstacles");
  Pair<sensor_msgs::Image> images(node, "/robot/image_raw");
  topics.tellTf();
  ASSERT_TRUE(topics.waitForListeners());
  topics.play(0, topics.robot.frames);
  const auto last = static_cast<unsigned>(topics.robot.frames) - 1;
  ASSERT_TRUE(waitFor([&] {
    return obstacles.sums.size() >= 15 && obstacles.first.last().frame == last &&
           obstacles.second.size() == obstacles.first.size() &&
           obstacles.sums.size() == obstacles.first.size();
  }));

  // Difference and mask take over the header of their picture, obstacles make one of their own.
  images.expectSharedAndUntouched(SyntheticRobot::marked_seq);
  differences.expectSharedAndUntouched(SyntheticRobot::marked_seq);
  masks.expectSharedAndUntouched(SyntheticRobot::marked_seq);
  obstacles.expectSharedAndUntouched(0);
  for (const char* topic : {"/difference", "/mask", "/obstacles"}) {
    const auto transports = transportsOf(topic);
    // A publisher and a subscriber end of the one link that this process has with itself.
    EXPECT_FALSE(transports.empty()) << topic;
    for (const std::string& transport : transports) EXPECT_EQ(transport, "INTRAPROCESS") << topic;
  }
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "zero_copy_rostest");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
