#include "ipm_mapping/ros/stamp_matcher.hpp"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <set>

namespace ipm_mapping {
namespace {

using Matcher = StampMatcher<int, int, double>;

boost::shared_ptr<const int> number(int value) { return boost::make_shared<int>(value); }
boost::shared_ptr<const double> real(double value) { return boost::make_shared<double>(value); }

TEST(StampMatcher, GivesASetWhenItsLastTopicHasSpoken) {
  Matcher matcher(4);
  EXPECT_FALSE(matcher.add<2>(10, real(0.5)));
  EXPECT_FALSE(matcher.add<0>(10, number(1)));
  const auto set = matcher.add<1>(10, number(2));
  ASSERT_TRUE(set);
  EXPECT_EQ(*std::get<0>(*set), 1);
  EXPECT_EQ(*std::get<1>(*set), 2);
  EXPECT_EQ(*std::get<2>(*set), 0.5);
  EXPECT_EQ(matcher.waiting(), 0U);
}

TEST(StampMatcher, KeepsFramesApartWhenOneSideIsLate) {
  Matcher matcher(8);
  for (unsigned stamp = 1; stamp <= 5; ++stamp) {
    matcher.add<0>(stamp, number(static_cast<int>(stamp)));
    matcher.add<1>(stamp, number(10 * static_cast<int>(stamp)));
  }
  for (unsigned stamp = 1; stamp <= 5; ++stamp) {
    const auto set = matcher.add<2>(stamp, real(stamp));
    ASSERT_TRUE(set);
    EXPECT_EQ(*std::get<0>(*set), static_cast<int>(stamp));
    EXPECT_EQ(*std::get<1>(*set), 10 * static_cast<int>(stamp));
  }
  EXPECT_EQ(matcher.incomplete(), 0U);
}

TEST(StampMatcher, GivesUpWhatALaterSetHasOvertaken) {
  Matcher matcher(8);
  matcher.add<0>(1, number(1));
  matcher.add<0>(2, number(2));
  matcher.add<1>(2, number(2));
  EXPECT_TRUE(matcher.add<2>(2, real(2)));
  EXPECT_EQ(matcher.waiting(), 0U);
  EXPECT_EQ(matcher.incomplete(), 1U);
}

TEST(StampMatcher, HoldsABoundedNumberAndDropsTheOldest) {
  Matcher matcher(3);
  for (unsigned stamp = 1; stamp <= 10; ++stamp) {
    matcher.add<0>(stamp, number(static_cast<int>(stamp)));
    EXPECT_LE(matcher.waiting(), 3U);
  }
  EXPECT_EQ(matcher.incomplete(), 7U);
  matcher.add<1>(8, number(8));
  EXPECT_TRUE(matcher.add<2>(8, real(8)));
}

TEST(StampMatcher, NeverMixesTheLapsOfALoopingBag) {
  Matcher matcher(16);
  const auto lap = [&](int value, unsigned first, unsigned last) {
    std::set<unsigned> matched;
    for (unsigned stamp = first; stamp <= last; ++stamp) {
      matcher.add<0>(stamp, number(value));
      matcher.add<1>(stamp, number(value));
      if (value == 1 && stamp > 3) continue;  // the first lap breaks off inside a frame
      const auto set = matcher.add<2>(stamp, real(value));
      if (!set) continue;
      EXPECT_EQ(*std::get<0>(*set), value);
      EXPECT_EQ(*std::get<1>(*set), value);
      EXPECT_EQ(*std::get<2>(*set), value);
      matched.insert(stamp);
    }
    return matched;
  };
  EXPECT_EQ(lap(1, 1, 5), (std::set<unsigned>{1, 2, 3}));
  EXPECT_EQ(lap(2, 1, 6), (std::set<unsigned>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(matcher.waiting(), 0U);
}

}  // namespace
}  // namespace ipm_mapping
