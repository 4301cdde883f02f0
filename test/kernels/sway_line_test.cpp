#include "ipm_mapping/kernels/sway_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "kernels/sweep_targets.hpp"

namespace ipm_mapping {
namespace {

constexpr int rows = 61, lines = 9;

Image<std::uint8_t> noise() {
  std::mt19937 random(3);
  Image<std::uint8_t> image(rows, lines);
  for (int line = 0; line < lines; ++line)
    for (int row = 0; row < rows; ++row)
      image.at(row, line) = static_cast<std::uint8_t>(random() % 256);
  return image;
}

struct Shift {
  std::vector<float> stretch, r;
  float along, across;

  Shift(float along_rows, float across_lines)
      : stretch(rows + kernels::overrun),
        r(stretch.size()),
        along(along_rows),
        across(across_lines) {
    for (std::size_t row = 0; row < r.size(); ++row) {
      r[row] = 0.05F * std::exp(0.05F * static_cast<float>(row));
      stretch[row] = (1.0F + r[row] * r[row]) / r[row];
    }
  }
  [[nodiscard]] kernels::SwayShift view() const {
    return {stretch.data(), r.data(), along, across};
  }
};

/// Bilinear, one pixel at a time.
double expected(const Image<std::uint8_t>& image, int line, const Shift& shift, int row, int begin,
                int end) {
  const auto i = static_cast<std::size_t>(row);
  const double to = std::clamp(row + static_cast<double>(shift.along * shift.stretch[i]),
                               static_cast<double>(begin), end - 1.0);
  const double beside =
      std::clamp(line + static_cast<double>(shift.across * shift.r[i]), 0.0, lines - 1.0);
  const int ir = std::min(static_cast<int>(to), end - 2);
  const int il = std::min(static_cast<int>(beside), lines - 2);
  const double a = to - ir, b = beside - il;
  return (1 - b) * ((1 - a) * image.at(ir, il) + a * image.at(ir + 1, il)) +
         b * ((1 - a) * image.at(ir, il + 1) + a * image.at(ir + 1, il + 1));
}

TEST(SwayLine, IsTheBilinearSampleOnEveryTarget) {
  const Image<std::uint8_t> image = noise();
  for (const auto& [along, across] :
       {std::pair{0.0F, 0.0F}, std::pair{0.12F, 0.7F}, std::pair{-0.3F, -0.9F},
        std::pair{40.0F, 60.0F}, std::pair{-40.0F, -60.0F}}) {
    const Shift shift(along, across);
    for (const auto& [begin, end] : {std::pair{0, rows}, std::pair{7, 9}, std::pair{5, 44}}) {
      for (const int line : {0, 4, lines - 1}) {
        std::vector<std::uint8_t> first;
        test::withEverySweepTarget([&, begin = begin, end = end] {
          std::vector<std::uint8_t> out(rows + kernels::overrun, 0);
          kernels::swayLine(image.view(), line, shift.view(), begin, end, out.data());
          for (int row = begin; row < end; ++row)
            ASSERT_NEAR(out[static_cast<std::size_t>(row)],
                        expected(image, line, shift, row, begin, end), 0.51)
                << row << ' ' << line;
          out.resize(static_cast<std::size_t>(end));
          if (first.empty()) first = out;
          EXPECT_EQ(out, first);
        });
      }
    }
  }
}

}  // namespace
}  // namespace ipm_mapping
