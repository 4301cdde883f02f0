#include "ipm_mapping/ros/waiting_clock.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/frame_gate.hpp"

namespace ipm_mapping {
namespace {

TEST(WaitingClock, RunsWithTheOtherClockWhileSomebodyLooksOften) {
  WaitingClock clock;
  const double begin = clock.look(5000.0);
  for (int i = 1; i <= 100; ++i) clock.look(5000.0 + 0.2 * i);
  EXPECT_NEAR(clock.look(5020.0) - begin, 20.0, 1e-6);
}

TEST(WaitingClock, CountsALongPauseAsOneStepAndNeverGoesBack) {
  WaitingClock clock;
  const double begin = clock.look(5000.0);
  EXPECT_DOUBLE_EQ(clock.look(5060.0) - begin, WaitingClock::longest_step);
  const double before = clock.look(5060.1);
  EXPECT_EQ(clock.look(5060.0), before);
}

TEST(WaitingClock, AStalledProcessLosesNoFrameThatOdometryReachesLater) {
  WaitingClock clock;
  FrameGate<int> gate;  // waits one second
  FrameGate<int>::Released released;
  gate.addOdometry(9.9, {}, clock.look(100.0));
  gate.addFrame(10.0, 0, clock.look(100.1));
  EXPECT_FALSE(gate.next(released, clock.look(100.1)));
  // Three seconds without CPU time: images are read first, odometry next.
  for (int i = 1; i <= 30; ++i) {
    gate.addFrame(10.0 + 0.1 * i, i, clock.look(103.1));
    EXPECT_FALSE(gate.next(released, clock.look(103.1)));
  }
  int taken = 0;
  for (int k = 0; k <= 160; ++k) {
    gate.addOdometry(9.92 + 0.02 * k, {}, clock.look(103.2));
    while (gate.next(released, clock.look(103.2))) EXPECT_EQ(released.payload, taken++);
  }
  EXPECT_EQ(taken, 31);
  EXPECT_EQ(gate.dropped(GateDrop::NoOdometry), 0U);
}

}  // namespace
}  // namespace ipm_mapping
