// Plays the synthetic robot once, slowly enough for every queue, as soon as the chain listens and
// the test has set the parameter /listening; then keeps its latched topics alive. ~compressed sends
// PNG pictures instead of raw ones; ~seconds is what a frame takes (0.05), ~listeners how many have
// to wait for the pictures.

#include <cv_bridge/cv_bridge.h>

#include <algorithm>

#include "chain_client.hpp"

int main(int argc, char** argv) {
  using namespace ipm_mapping;
  ros::init(argc, argv, "synthetic_robot_player");
  ros::NodeHandle node, private_node("~");
  const bool compressed = private_node.param("compressed", false);
  const double seconds = private_node.param("seconds", 0.05);
  const int listeners = private_node.param("listeners", 1);
  RobotTopics topics(node);
  ros::Publisher pictures =
      node.advertise<sensor_msgs::CompressedImage>("/robot/image_raw/compressed", 1000);
  topics.tellTf();
  const bool awake = waitFor(
      [&] {
        const int raw = topics.listeners(), png = static_cast<int>(pictures.getNumSubscribers());
        return std::max(raw, png) >= listeners && ros::param::param("/listening", false);
      },
      60.0);
  if (!awake) return 1;
  waitFor([] { return false; }, 0.5);
  for (int i = 0; i < topics.robot.frames; ++i) {
    const double t = topics.robot.frameTime(i);
    if (compressed) {
      const auto image = topics.robot.image(topics.stamp(t), topics.robot.pose(t));
      pictures.publish(cv_bridge::toCvCopy(image)->toCompressedImageMsg(cv_bridge::PNG));
    }
    topics.play(i, i + 1, !compressed);
    ros::WallDuration(seconds).sleep();
  }
  ros::spin();
  return 0;
}
