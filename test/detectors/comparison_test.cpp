#include "ipm_mapping/detectors/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {
namespace {

GrayView viewOf(const Image<std::uint8_t>& image) { return image.view(); }

Image<std::uint8_t> randomImage(int width, int height, unsigned seed, int levels, int step) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> level(0, levels - 1);
  Image<std::uint8_t> image(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      image.at(u, v) = static_cast<std::uint8_t>(level(random) * step);
  return image;
}

Contact contactAt(float x, float y) {
  Contact contact;
  contact.p_base = {x, y};
  return contact;
}

TEST(Comparison, CountsEveryPixelOnceByWhoHasSeenIt) {
  const auto a = randomImage(13, 7, 1, 256, 1), b = randomImage(13, 7, 2, 256, 1);
  const auto seen_a = randomImage(13, 7, 3, 2, 255), seen_b = randomImage(13, 7, 4, 2, 255);
  const auto result = compareDifferences(viewOf(a), viewOf(seen_a), viewOf(b), viewOf(seen_b));
  std::uint32_t compared = 0, changed = 0, once = 0;
  int max = 0, sum = 0;
  for (int v = 0; v < 7; ++v)
    for (int u = 0; u < 13; ++u) {
      once += seen_a.at(u, v) != seen_b.at(u, v);
      if (seen_a.at(u, v) == 0 || seen_b.at(u, v) == 0) continue;
      ++compared;
      changed += a.at(u, v) != b.at(u, v);
      sum += std::abs(a.at(u, v) - b.at(u, v));
      max = std::max(max, std::abs(a.at(u, v) - b.at(u, v)));
    }
  ASSERT_GT(compared, 10U);
  ASSERT_GT(once, 10U);
  EXPECT_EQ(result.compared, compared);
  EXPECT_EQ(result.changed, changed);
  EXPECT_EQ(result.seen_once, once);
  EXPECT_EQ(result.max, max);
  EXPECT_DOUBLE_EQ(result.mean, static_cast<double>(sum) / compared);
  EXPECT_FALSE(result.equal());
}

TEST(Comparison, APictureEqualsItselfEvenWhereNobodyHasSeenIt) {
  const auto a = randomImage(16, 8, 1, 256, 1);
  auto b = a;
  auto seen = randomImage(16, 8, 3, 2, 255);
  seen.at(3, 2) = 0;
  b.at(3, 2) = static_cast<std::uint8_t>(a.at(3, 2) + 1);
  const auto result = compareDifferences(viewOf(a), viewOf(seen), viewOf(b), viewOf(seen));
  EXPECT_TRUE(result.equal());
  EXPECT_EQ(result.max, 0);
  seen.at(3, 2) = 255;
  EXPECT_FALSE(compareDifferences(viewOf(a), viewOf(seen), viewOf(b), viewOf(seen)).equal());
}

TEST(Comparison, APixelSeenByOneSideAloneIsNoAgreement) {
  const Image<std::uint8_t> grey(4, 4, 9);
  Image<std::uint8_t> all(4, 4, 255), hole(4, 4, 255);
  hole.at(1, 1) = 0;
  const auto result = compareDifferences(viewOf(grey), viewOf(all), viewOf(grey), viewOf(hole));
  EXPECT_EQ(result.changed, 0U);
  EXPECT_EQ(result.seen_once, 1U);
  EXPECT_FALSE(result.equal());
}

TEST(Comparison, ObstacleAgainstFloorIsADifferenceOfOne) {
  Image<std::uint8_t> a(5, 2, mask::floor), b(5, 2, mask::floor);
  a.at(0, 0) = mask::obstacle;
  b.at(1, 0) = mask::obstacle;
  a.at(2, 0) = b.at(2, 0) = mask::obstacle;
  a.at(3, 0) = mask::unseen;
  b.at(4, 0) = a.at(4, 0) = mask::unseen;
  const auto result = compareMasks(viewOf(a), viewOf(b));
  EXPECT_EQ(result.compared, 8U);
  EXPECT_EQ(result.changed, 2U);
  EXPECT_EQ(result.seen_once, 1U);
  EXPECT_EQ(result.max, 1);
  EXPECT_DOUBLE_EQ(result.mean, 0.25);
}

TEST(Comparison, PicturesOfDifferentSizesAreNeverEqual) {
  const Image<std::uint8_t> a(4, 4), b(4, 5);
  EXPECT_FALSE(compareMasks(viewOf(a), viewOf(b)).equal());
  EXPECT_FALSE(compareDifferences(viewOf(a), viewOf(a), viewOf(b), viewOf(b)).equal());
  EXPECT_FALSE(compareDifferences(viewOf(a), viewOf(b), viewOf(a), viewOf(a)).equal());
}

TEST(Comparison, ContactDistanceIsThatOfTheNearestPointBothWays) {
  const std::vector<Contact> a{contactAt(1, 0), contactAt(2, 0)};
  const std::vector<Contact> b{contactAt(1, 0.5F)};
  const auto result = compareContacts(a, b);
  const double far = std::hypot(1.0, 0.5);
  EXPECT_EQ(result.points_a, 2U);
  EXPECT_EQ(result.points_b, 1U);
  EXPECT_NEAR(result.max_distance, far, 1e-6);
  EXPECT_NEAR(result.mean_distance, (0.5 + far + 0.5) / 3.0, 1e-6);
  const auto swapped = compareContacts(b, a);
  EXPECT_DOUBLE_EQ(swapped.max_distance, result.max_distance);
  EXPECT_DOUBLE_EQ(swapped.mean_distance, result.mean_distance);
}

TEST(Comparison, ContactsAreEqualInAnyOrderButNotInAnyNumber) {
  const std::vector<Contact> a{contactAt(1, 0), contactAt(2, 1)};
  const std::vector<Contact> turned{contactAt(2, 1), contactAt(1, 0)};
  EXPECT_TRUE(compareContacts(a, turned).equal());
  EXPECT_FALSE(compareContacts(a, {contactAt(1, 0), contactAt(2, 1), contactAt(2, 1)}).equal());
  EXPECT_TRUE(compareContacts({}, {}).equal());
}

TEST(Comparison, WithoutAPointOnOneSideThereIsNoDistance) {
  const auto result = compareContacts({contactAt(1, 0)}, {});
  EXPECT_TRUE(std::isnan(result.max_distance));
  EXPECT_TRUE(std::isnan(result.mean_distance));
  EXPECT_FALSE(result.equal());
}

}  // namespace
}  // namespace ipm_mapping
