#include "ipm_mapping/kernels/sweep_rectify.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "kernels/sweep_targets.hpp"

namespace ipm_mapping {
namespace {

using test::withEverySweepTarget;

Image<std::uint8_t> noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<std::uint8_t> image(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) image.at(u, v) = static_cast<std::uint8_t>(random() & 255U);
  return image;
}

std::uint8_t slowSmooth(const Image<std::uint8_t>& in, int u, int v) {
  int sum = 0;
  for (int dv = -1; dv <= 1; ++dv)
    for (int du = -1; du <= 1; ++du) {
      const int weight = (2 - std::abs(du)) * (2 - std::abs(dv));
      sum += weight *
             in.at(std::clamp(u + du, 0, in.width() - 1), std::clamp(v + dv, 0, in.height() - 1));
    }
  return static_cast<std::uint8_t>((sum + 8) / 16);
}

TEST(SweepRectifyKernels, SmoothingEqualsTheDefinitionAtEverySizeAndBorder) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 3}, {17, 5}, {64, 9}, {131, 4}}) {
    const auto in = noise(width, height, 7);
    withEverySweepTarget([&, w = width, h = height] {
      Image<std::uint8_t> out(w, h);
      kernels::smooth121(in.view(), out.view());
      for (int v = 0; v < h; ++v)
        for (int u = 0; u < w; ++u)
          ASSERT_EQ(out.at(u, v), slowSmooth(in, u, v)) << u << ' ' << v << " of " << w;
    });
  }
}

TEST(SweepRectifyKernels, PairsHoldAPixelAndTheOneBelow) {
  const auto in = noise(45, 6, 3);
  withEverySweepTarget([&] {
    Image<std::uint16_t> out(45, 6);
    kernels::pairRows(in.view(), out.view());
    for (int v = 0; v < 6; ++v)
      for (int u = 0; u < 45; ++u)
        ASSERT_EQ(out.at(u, v), in.at(u, v) + 256 * in.at(u, std::min(v + 1, 5)));
  });
}

TEST(SweepRectifyKernels, SamplesAreWeightedSumsOfFourNeighbours) {
  const int width = 50, height = 20;
  const auto in = noise(width, height, 5);
  std::mt19937 random(11);
  for (const int count : {0, 1, 7, 16, 33, 100}) {
    std::vector<std::int32_t> offsets;
    std::vector<std::uint32_t> weights;
    std::vector<int> expected;
    for (int i = 0; i < count; ++i) {
      const int u = static_cast<int>(random() % (width - 1)),
                v = static_cast<int>(random() % (height - 1));
      const auto draw = [&](unsigned below) { return static_cast<unsigned>(random() % below); };
      const unsigned a = draw(129), b = draw(129 - a), c = draw(129 - a - b);
      const unsigned d = 128 - a - b - c;
      offsets.push_back(2 * (v * width + u));
      weights.push_back(a | b << 8 | c << 16 | d << 24);
      const unsigned sum =
          a * in.at(u, v) + b * in.at(u, v + 1) + c * in.at(u + 1, v) + d * in.at(u + 1, v + 1);
      expected.push_back(static_cast<int>((sum + 64) / 128));
    }
    withEverySweepTarget([&] {
      Image<std::uint16_t> pairs(width, height);
      kernels::pairRows(in.view(), pairs.view());
      std::vector<std::uint8_t> out(static_cast<std::size_t>(count) + 1, 77);
      kernels::samplePlan(pairs.view(), offsets.data(), weights.data(), count, out.data());
      for (int i = 0; i < count; ++i)
        ASSERT_EQ(out[static_cast<std::size_t>(i)], expected[static_cast<std::size_t>(i)]) << i;
      EXPECT_EQ(out.back(), 77) << "wrote past the end";
    });
  }
}

}  // namespace
}  // namespace ipm_mapping
