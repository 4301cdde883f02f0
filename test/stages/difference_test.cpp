#include "ipm_mapping/stages/difference.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

TEST(Difference, IsAbsoluteForEveryPairOfGreyLevels) {
  Picture a(256, 256), b(256, 256), valid(256, 256, 255), out(256, 256), expected(256, 256);
  for (int v = 0; v < 256; ++v) {
    for (int u = 0; u < 256; ++u) {
      a(u, v) = static_cast<std::uint8_t>(u);
      b(u, v) = static_cast<std::uint8_t>(v);
    }
  }
  absoluteDifference(a.view(), b.view(), valid.view(), out.view());
  cv::absdiff(a.mat(), b.mat(), expected.mat());
  EXPECT_TRUE(equal(out, expected));
}

TEST(Difference, IsZeroWhereNotValidAtEverySize) {
  std::mt19937 random(1);
  for (const cv::Size size : awkwardSizes()) {
    const Picture a = noise(size.width, size.height, random);
    const Picture b = noise(size.width, size.height, random);
    const Picture valid = speckle(size.width, size.height, random, 0.7);
    Picture out(size.width, size.height, 77), expected(size.width, size.height);
    for (int v = 0; v < size.height; ++v)
      for (int u = 0; u < size.width; ++u)
        expected(u, v) =
            static_cast<std::uint8_t>(valid(u, v) ? std::abs(int{a(u, v)} - int{b(u, v)}) : 0);
    absoluteDifference(a.view(), b.view(), valid.view(), out.view());
    EXPECT_TRUE(equal(out, expected)) << size;
  }
}

}  // namespace
}  // namespace ipm_mapping::test
