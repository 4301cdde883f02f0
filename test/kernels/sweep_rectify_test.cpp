#include "ipm_mapping/kernels/sweep_rectify.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "ipm_mapping/kernels/sweep_costs.hpp"
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

TEST(SweepRectifyKernels, AMovedPlanSamplesWhereRowsAndLinesLead) {
  constexpr int width = 60, height = 40, rows = 50, begin = 1, end = 48;
  const auto padded = static_cast<std::size_t>(rows + kernels::overrun);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::array<std::vector<float>, 7> tables;  // u and v here, before, after; nearness
  for (auto& table : tables) table.resize(padded);
  auto& [u, v, u_before, v_before, u_after, v_after, nearness] = tables;
  for (std::size_t i = 0; i < padded; ++i) {
    u[i] = 5.0F + 0.9F * static_cast<float>(i) + unit(random);
    v[i] = 30.0F - 0.4F * static_cast<float>(i) + unit(random);
    u_before[i] = u[i] - 1.3F - 0.1F * unit(random);
    u_after[i] = u[i] + 1.2F;
    v_before[i] = v[i] + 0.2F;
    v_after[i] = v[i] - 0.3F * unit(random);
    nearness[i] = 2.0F * unit(random);
  }
  const auto in = noise(width, height, 5);
  Image<std::uint16_t> pairs(width, height);
  kernels::pairRows(in.view(), pairs.view());
  const kernels::RawLine line{u.data(),        v.data(),       u_before.data(),
                              v_before.data(), u_after.data(), v_after.data()};
  const kernels::MovedRows moved{nearness.data(), 5.0F, 12.0F, -7.0F, 4.0F, 3.0F};
  const kernels::RawBounds bounds{2.0F, width - 3.0F, height - 3.0F, 1.0F / (height - 1), width};
  std::vector<std::int32_t> first_offsets;
  std::vector<std::uint32_t> first_weights;
  withEverySweepTarget([&] {
    std::vector<std::int32_t> offsets(padded);
    std::vector<std::uint32_t> weights(padded);
    kernels::movedPlan(line, moved, bounds, begin, end, offsets.data(), weights.data());
    std::vector<std::uint8_t> out(padded);
    const std::vector<std::uint16_t> gains(padded, kernels::no_gain);
    kernels::samplePlan(pairs.view(), offsets.data(), weights.data(), gains.data(), end - begin,
                        out.data());
    for (int row = begin; row < end; ++row) {
      const auto i = static_cast<std::size_t>(row);
      const double time = static_cast<double>(v[i]) / (height - 1) - 0.5;
      const double near = static_cast<double>(nearness[i]),
                   along = std::clamp(5.0 * time * near, -3.0, 3.0);
      const double across = std::clamp(time * (12.0 - 7.0 * near), -4.0, 4.0);
      const auto led = [&](const std::vector<float>& here, const std::vector<float>& before,
                           const std::vector<float>& after, double most) {
        const double to = static_cast<double>(here[i]) +
                          0.5 * along * static_cast<double>(here[i + 1] - here[i - 1]) +
                          0.5 * across * static_cast<double>(after[i] - before[i]);
        return std::clamp(to, 2.0, most);
      };
      const double x = led(u, u_before, u_after, width - 3.0);
      const double y = led(v, v_before, v_after, height - 3.0);
      const int iu = static_cast<int>(x), iv = static_cast<int>(y);
      const double a = x - iu, b = y - iv;
      const double expected = (1 - b) * ((1 - a) * in.at(iu, iv) + a * in.at(iu + 1, iv)) +
                              b * ((1 - a) * in.at(iu, iv + 1) + a * in.at(iu + 1, iv + 1));
      ASSERT_NEAR(out[static_cast<std::size_t>(row - begin)], expected, 3.0) << row;
      std::uint32_t sum = 0;
      for (int k = 0; k < 4; ++k)
        sum += weights[static_cast<std::size_t>(row - begin)] >> (8 * k) & 255U;
      ASSERT_EQ(sum, 128U);
    }
    offsets.resize(end - begin);
    weights.resize(end - begin);
    if (first_offsets.empty()) first_offsets = offsets, first_weights = weights;
    EXPECT_EQ(offsets, first_offsets) << "every target gives the same plan";
    EXPECT_EQ(weights, first_weights);
  });
}

TEST(SweepRectifyKernels, SamplesAreWeightedSumsOfFourNeighbours) {
  const int width = 50, height = 20;
  const auto in = noise(width, height, 5);
  std::mt19937 random(11);
  for (const int count : {0, 1, 7, 16, 33, 100}) {
    std::vector<std::int32_t> offsets;
    std::vector<std::uint32_t> weights;
    std::vector<std::uint16_t> gains;
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
      const unsigned gain = i % 3 == 0 ? kernels::no_gain : draw(3 * kernels::no_gain);
      gains.push_back(static_cast<std::uint16_t>(gain));
      const double grey = sum / 128.0 * gain / kernels::no_gain;
      expected.push_back(static_cast<int>(std::min(std::floor(grey + 0.5), 255.0)));
    }
    withEverySweepTarget([&] {
      Image<std::uint16_t> pairs(width, height);
      kernels::pairRows(in.view(), pairs.view());
      std::vector<std::uint8_t> out(static_cast<std::size_t>(count) + 1, 77);
      kernels::samplePlan(pairs.view(), offsets.data(), weights.data(), gains.data(), count,
                          out.data());
      for (int i = 0; i < count; ++i)
        ASSERT_EQ(out[static_cast<std::size_t>(i)], expected[static_cast<std::size_t>(i)]) << i;
      EXPECT_EQ(out.back(), 77) << "wrote past the end";
    });
  }
}

}  // namespace
}  // namespace ipm_mapping
