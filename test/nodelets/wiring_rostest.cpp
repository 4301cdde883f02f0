// Nodelets of one process connect their topics one after the other, whichever threads they start
// in: two at a time, and roscpp may connect them twice (ros/wiring.hpp).

#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <std_msgs/Empty.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "ipm_mapping/ros/lazy_outputs.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"

namespace ipm_mapping {
namespace {

/// How many are connecting topics at this moment, and the most there ever were.
class Crowd {
 public:
  void visit() {
    const int now = ++inside_;
    for (int most = most_; now > most && !most_.compare_exchange_weak(most, now);) continue;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    --inside_;
    ++visits_;
  }
  [[nodiscard]] int most() const { return most_; }
  [[nodiscard]] int visits() const { return visits_; }

 private:
  std::atomic<int> inside_{0}, most_{0}, visits_{0};
};

class Slow : public StageNodelet {
 public:
  explicit Slow(Crowd& crowd) : crowd_(crowd) {}

 private:
  void start() override {
    outputs_.advertise<std_msgs::Empty>(node(), "output");
    crowd_.visit();
  }

  Crowd& crowd_;
  LazyOutputs outputs_{[this](bool) { crowd_.visit(); }};
};

/// A nodelet with threads of its own, as a manager gives it.
struct Running {
  Running(const std::string& name, Crowd& crowd) : nodelet(new Slow(crowd)) {
    nodelet->init(name, {}, {}, &queue, &queue);
    spinner.start();
  }
  ros::CallbackQueue queue;
  ros::AsyncSpinner spinner{1, &queue};
  std::unique_ptr<nodelet::Nodelet> nodelet;
};

void waitFor(const Crowd& crowd, int visits) {
  for (int i = 0; i < 200 && crowd.visits() < visits; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  ASSERT_EQ(crowd.visits(), visits);
}

TEST(Wiring, NodeletsStartOneAfterTheOther) {
  Crowd crowd;
  Running a("/wiring_a/nodelet", crowd), b("/wiring_b/nodelet", crowd),
      c("/wiring_c/nodelet", crowd);
  waitFor(crowd, 3);
  EXPECT_EQ(crowd.most(), 1);
}

TEST(Wiring, WhoWakesUpWaitsForWhoStarts) {
  Crowd crowd;
  Running first("/wiring_first/nodelet", crowd);
  waitFor(crowd, 1);
  ros::NodeHandle node;
  const ros::Subscriber listener = node.subscribe<std_msgs::Empty>(
      "/wiring_first/output", 1,
      boost::function<void(const std_msgs::EmptyConstPtr&)>([](auto&) {}));
  Running second("/wiring_second/nodelet", crowd), third("/wiring_third/nodelet", crowd);
  waitFor(crowd, 4);
  EXPECT_EQ(crowd.most(), 1);
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "wiring_rostest");
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
