#include "ipm_mapping/ros/sequence_gaps.hpp"

#include <gtest/gtest.h>

namespace ipm_mapping {
namespace {

TEST(SequenceGaps, CountWhatIsMissing) {
  SequenceGaps gaps;
  EXPECT_EQ(gaps.missing(7), 0U);  // nobody knows what was before
  EXPECT_EQ(gaps.missing(8), 0U);
  EXPECT_EQ(gaps.missing(12), 3U);
  EXPECT_EQ(gaps.missing(13), 0U);
}

TEST(SequenceGaps, AnotherPublisherIsNoGap) {
  SequenceGaps gaps;
  gaps.missing(5000);
  EXPECT_EQ(gaps.missing(1), 0U);  // it began anew
  EXPECT_EQ(gaps.missing(2), 0U);
  EXPECT_EQ(gaps.missing(5001), 0U);  // two at a time
  EXPECT_EQ(gaps.missing(3), 0U);
}

/// Within a process messages are handed over as they are, most with no number.
TEST(SequenceGaps, NumbersThatAreNotGivenAreNoGap) {
  SequenceGaps gaps;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(gaps.missing(0), 0U);
}

}  // namespace
}  // namespace ipm_mapping
