#include "ipm_mapping/ros/fault_log.hpp"

#include <gtest/gtest.h>

namespace ipm_mapping {
namespace {

TEST(FaultLog, KeepsEverySentenceWithItsCountInTheOrderOfTheFirst) {
  FaultLog log;
  for (const char* sentence : {"no odometry", "bad image", "no odometry", "no camera", "bad image"})
    log.add(sentence);
  ASSERT_EQ(log.faults().size(), 3U);
  EXPECT_EQ(log.faults()[0].sentence, "no odometry");
  EXPECT_EQ(log.faults()[0].count, 2U);
  EXPECT_EQ(log.faults()[1].sentence, "bad image");
  EXPECT_EQ(log.faults()[1].count, 2U);
  EXPECT_EQ(log.faults()[2].sentence, "no camera");
  EXPECT_EQ(log.faults()[2].count, 1U);
  EXPECT_EQ(log.others(), 0U);
}

TEST(FaultLog, TheCommonestIsTheEarlierOfEquals) {
  FaultLog log;
  EXPECT_EQ(log.commonest(), "");
  for (const char* sentence : {"a", "b", "c", "b", "c"}) log.add(sentence);
  EXPECT_EQ(log.commonest(), "b");
  log.add("c");
  EXPECT_EQ(log.commonest(), "c");
}

TEST(FaultLog, IsBoundedAndCountsWhatItCannotKeep) {
  FaultLog log;
  for (int round = 0; round < 2; ++round)
    for (std::size_t i = 0; i < FaultLog::most_sentences + 5; ++i)
      log.add("sentence " + std::to_string(i));
  EXPECT_EQ(log.faults().size(), FaultLog::most_sentences);
  for (const FaultLog::Fault& fault : log.faults()) EXPECT_EQ(fault.count, 2U) << fault.sentence;
  EXPECT_EQ(log.others(), 10U);
}

TEST(FaultLog, StartsAnewAfterALook) {
  FaultLog log;
  for (std::size_t i = 0; i < FaultLog::most_sentences + 1; ++i) log.add(std::to_string(i));
  log.clear();
  EXPECT_TRUE(log.faults().empty());
  EXPECT_EQ(log.others(), 0U);
  log.add("again");
  EXPECT_EQ(log.faults().at(0).count, 1U);
}

}  // namespace
}  // namespace ipm_mapping
