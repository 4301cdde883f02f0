#include "ipm_mapping/kernels/sweep_alignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "kernels/sweep_targets.hpp"

namespace ipm_mapping {
namespace {

using test::withEverySweepTarget;

using Array = std::vector<float>;

Array randomFloats(std::size_t count, float low, float high, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  Array values(count + kernels::overrun);
  for (float& v : values) v = value(random);
  return values;
}

constexpr std::size_t moves = kernels::alignment_moves;

/// Pointers to the arrays' elements.
template <class Arrays>
void point(Arrays& arrays, float* (&to)[moves]) {
  for (std::size_t k = 0; k < moves; ++k) to[k] = arrays[k].data();
}

struct Positions {
  Array row, line;
  std::array<Array, moves> d_row, d_line;

  explicit Positions(std::size_t n) : row(n), line(n) {
    for (auto* arrays : {&d_row, &d_line})
      for (Array& array : *arrays) array.resize(n);
  }
  kernels::SamplePositions view() {
    kernels::SamplePositions all;
    all.row = row.data();
    all.line = line.data();
    point(d_row, all.d_row);
    point(d_line, all.d_line);
    return all;
  }
};

constexpr double rows_per_log = 200.0, lines_per_radian = 400.0, log_height = -0.8, left = 0.7;
const double height = std::exp(log_height);
const Array foot{0.05F, -0.01F};

/// Exact position of a floor point for a motion (x, y, theta) of the base, pitch and roll of the
/// camera in the reference.
std::array<double, 2> exact(double x, double y, const std::array<double, moves>& motion) {
  const double c = std::cos(motion[2]), s = std::sin(motion[2]);
  const double bx = x + static_cast<double>(foot[0]), by = y + static_cast<double>(foot[1]);
  const double px = c * bx - s * by + motion[0] - static_cast<double>(foot[0]);
  const double py = s * bx + c * by + motion[1] - static_cast<double>(foot[1]);
  // Into the axes of the swayed camera: R_x(-roll) R_y(-pitch).
  const double cp = std::cos(motion[3]), sp = std::sin(motion[3]);
  const double cr = std::cos(motion[4]), sr = std::sin(motion[4]);
  const double nx = cp * px + sp * height, nz = sp * px - cp * height;
  const double ny = cr * py + sr * nz, down = sr * py - cr * nz;
  return {rows_per_log * (std::log(down / std::hypot(nx, ny)) + 2.0),
          lines_per_radian * (left - std::atan2(ny, nx))};
}

kernels::FloorProjection projection(const std::array<double, moves>& motion) {
  const double c = std::cos(motion[2]), s = std::sin(motion[2]);
  const double fx = static_cast<double>(foot[0]), fy = static_cast<double>(foot[1]);
  kernels::FloorProjection p;
  p.c = static_cast<float>(c);
  p.s = static_cast<float>(s);
  p.tx = static_cast<float>(c * fx - s * fy + motion[0] - fx);
  p.ty = static_cast<float>(s * fx + c * fy + motion[1] - fy);
  p.foot_x = foot[0];
  p.foot_y = foot[1];
  p.height = static_cast<float>(height);
  p.rows_per_log = rows_per_log;
  p.row_at_one = static_cast<float>(rows_per_log * (log_height + 2.0));
  p.lines_per_radian = lines_per_radian;
  p.line_ahead = static_cast<float>(lines_per_radian * left);
  return p;
}

TEST(SweepAlignmentKernels, ProjectionIsExactToAHundredthOfAPixelInEveryDirection) {
  const std::size_t n = 400;
  const Array x = randomFloats(n, -4.0F, 4.0F, 1), y = randomFloats(n, -4.0F, 4.0F, 2);
  const std::array<double, moves> motion{0.31, -0.02, 0.21};
  withEverySweepTarget([&] {
    Positions at(x.size());
    kernels::projectFloor(x.data(), y.data(), static_cast<int>(n), projection(motion), at.view());
    for (std::size_t i = 0; i < n; ++i) {
      const auto expected = exact(static_cast<double>(x[i]), static_cast<double>(y[i]), motion);
      ASSERT_NEAR(at.row[i], expected[0], 0.002) << x[i] << ' ' << y[i];
      ASSERT_NEAR(at.line[i], expected[1], 0.002) << x[i] << ' ' << y[i];
    }
  });
}

TEST(SweepAlignmentKernels, SlopesOfThePositionsAreThoseOfTheMotion) {
  const std::size_t n = 60;
  const Array x = randomFloats(n, 0.4F, 3.0F, 3), y = randomFloats(n, -1.0F, 1.0F, 4);
  const std::array<double, moves> motion{0.15, 0.01, -0.1};
  Positions at(x.size());
  kernels::projectFloor(x.data(), y.data(), static_cast<int>(n), projection(motion), at.view());
  for (std::size_t k = 0; k < moves; ++k) {
    const double step = 1e-5;
    auto more = motion, less = motion;
    more[k] += step;
    less[k] -= step;
    for (std::size_t i = 0; i < n; ++i) {
      const auto a = exact(static_cast<double>(x[i]), static_cast<double>(y[i]), more);
      const auto b = exact(static_cast<double>(x[i]), static_cast<double>(y[i]), less);
      ASSERT_NEAR(at.d_row[k][i], (a[0] - b[0]) / (2 * step), 0.01) << k;
      ASSERT_NEAR(at.d_line[k][i], (a[1] - b[1]) / (2 * step), 0.01) << k;
    }
  }
}

TEST(SweepAlignmentKernels, ProjectionHasTheSameBitsOnEveryTarget) {
  const Array x = randomFloats(333, -4.0F, 4.0F, 5), y = randomFloats(333, -4.0F, 4.0F, 6);
  Array row, line, by_turn;
  withEverySweepTarget([&] {
    Positions at(x.size());
    kernels::projectFloor(x.data(), y.data(), 333, projection({0.2, 0.0, 0.1}), at.view());
    for (Array* array : {&at.row, &at.line, &at.d_line[2]}) array->resize(333);
    if (row.empty()) row = at.row, line = at.line, by_turn = at.d_line[2];
    EXPECT_EQ(at.row, row);
    EXPECT_EQ(at.line, line);
    EXPECT_EQ(at.d_line[2], by_turn);
  });
}

struct Warped {
  Array grey, high;
  std::array<Array, moves> gradient;

  explicit Warped(std::size_t n) : grey(n), high(n) {
    for (Array& array : gradient) array.resize(n);
  }
  kernels::WarpedSamples view() {
    kernels::WarpedSamples all;
    all.grey = grey.data();
    all.high = high.data();
    point(gradient, all.gradient);
    return all;
  }
};

/// A plane: 10 + 2 row + line.
Image<std::uint8_t> plane() {
  Image<std::uint8_t> image(40, 30);
  for (int line = 0; line < 30; ++line)
    for (int row = 0; row < 40; ++row)
      image.at(row, line) = static_cast<std::uint8_t>(10 + 2 * row + line);
  return image;
}

TEST(SweepAlignmentKernels, SamplesOfAPlaneLieOnIt) {
  const std::size_t n = 77;
  Positions at(n + kernels::overrun);
  at.row = randomFloats(n, 2.0F, 30.0F, 7);
  at.line = randomFloats(n, 2.0F, 25.0F, 8);
  for (std::size_t k = 0; k < moves; ++k) {
    at.d_row[k] = randomFloats(n, -3.0F, 3.0F, 9 + static_cast<unsigned>(k));
    at.d_line[k] = randomFloats(n, -3.0F, 3.0F, 29 + static_cast<unsigned>(k));
  }
  const Array mean = randomFloats(n, 0.0F, 99.0F, 15);
  const std::array<float, moves> correction{0.2F, -0.1F, 0.05F, 0.03F, -0.04F};
  const Image<std::uint8_t> image = plane();
  withEverySweepTarget([&] {
    Warped out(mean.size());
    kernels::warpSamples(image.view(), at.view(), mean.data(), correction.data(),
                         static_cast<int>(n), out.view());
    for (std::size_t i = 0; i < n; ++i) {
      float row = at.row[i], line = at.line[i];
      for (std::size_t k = 0; k < moves; ++k) {
        row += at.d_row[k][i] * correction[k];
        line += at.d_line[k][i] * correction[k];
        ASSERT_NEAR(out.gradient[k][i], 2.0F * at.d_row[k][i] + at.d_line[k][i], 1e-4F);
      }
      ASSERT_NEAR(out.grey[i], 10.0F + 2.0F * row + line, 1e-3F);
      ASSERT_EQ(out.high[i], out.grey[i] - mean[i]);
    }
  });
}

TEST(SweepAlignmentKernels, PositionsOutsideStopAtTheBorder) {
  const Image<std::uint8_t> image = plane();
  Positions at(4 + kernels::overrun);
  at.row = {-50.0F, 500.0F, 5.0F, 5.0F};
  at.line = {5.0F, 5.0F, -50.0F, 500.0F};
  at.row.resize(4 + kernels::overrun);
  at.line.resize(at.row.size());
  const Array mean(at.row.size(), 0.0F);
  const std::array<float, moves> correction{};
  withEverySweepTarget([&] {
    Warped out(mean.size());
    kernels::warpSamples(image.view(), at.view(), mean.data(), correction.data(), 4, out.view());
    EXPECT_NEAR(out.grey[0], 10.0F + 5.0F, 0.1F);
    EXPECT_NEAR(out.grey[1], 10.0F + 2.0F * 39.0F + 5.0F, 0.1F);
    EXPECT_NEAR(out.grey[2], 10.0F + 2.0F * 5.0F, 0.1F);
    EXPECT_NEAR(out.grey[3], 10.0F + 2.0F * 5.0F + 29.0F, 0.1F);
  });
}

/// Samples with a few outliers.
struct Residuals {
  std::size_t n;
  Array current, warped;
  std::array<Array, moves> gradient;

  explicit Residuals(std::size_t count)
      : n(count),
        current(randomFloats(count, -20.0F, 20.0F, 16)),
        warped(randomFloats(count, -2.0F, 2.0F, 17)) {
    for (std::size_t i = 0; i < current.size(); ++i)
      if (i % 7 != 0) current[i] = 0.9F * warped[i] + 0.05F * current[i];
    for (std::size_t k = 0; k < moves; ++k)
      gradient[k] = randomFloats(count, -300.0F, 300.0F, 18 + static_cast<unsigned>(k));
  }
  [[nodiscard]] kernels::AlignmentResidual view() const {
    return {current.data(), warped.data(), 0.95F, 0.1F, static_cast<int>(n)};
  }
  [[nodiscard]] double e(std::size_t i) const {
    return static_cast<double>(current[i]) - (0.95 * static_cast<double>(warped[i]) + 0.1);
  }
};

TEST(SweepAlignmentKernels, NormalEquationsAreTheWeightedSumsAndTheSameOnEveryTarget) {
  for (const std::size_t n : {1U, 7U, 8U, 61U, 1003U}) {
    const Residuals data(n);
    const double limit = 5.0;
    std::array<double, kernels::alignment_sums> expected{}, first{};
    std::array<double, kernels::alignment_sums> size{};  // of what is added up
    for (std::size_t i = 0; i < n; ++i) {
      const double share = data.e(i) / limit, rest = std::max(0.0, 1.0 - share * share);
      const double w = rest * rest;
      std::array<double, kernels::alignment_unknowns> J;
      for (std::size_t k = 0; k < moves; ++k) J[k] = static_cast<double>(data.gradient[k][i]);
      J[moves] = static_cast<double>(data.warped[i]);
      J[moves + 1] = 1.0;
      std::size_t at = J.size();
      for (std::size_t row = 0; row < J.size(); ++row) {
        expected[row] += w * data.e(i) * J[row];
        size[row] += std::abs(w * data.e(i) * J[row]);
        for (std::size_t column = row; column < J.size(); ++column, ++at) {
          expected[at] += w * J[row] * J[column];
          size[at] += std::abs(w * J[row] * J[column]);
        }
      }
    }
    bool any = false;
    std::array<const float*, moves> gradient;
    for (std::size_t k = 0; k < moves; ++k) gradient[k] = data.gradient[k].data();
    withEverySweepTarget([&] {
      std::array<double, kernels::alignment_sums> sums{};
      kernels::alignmentSums(data.view(), gradient.data(), static_cast<float>(limit), sums.data());
      for (std::size_t k = 0; k < sums.size(); ++k)
        ASSERT_NEAR(sums[k], expected[k], 2e-5 * size[k]) << k;
      if (!any) first = sums;
      any = true;
      EXPECT_EQ(sums, first);
    });
  }
}

TEST(SweepAlignmentKernels, MedianIsThatOfASortedList) {
  for (const std::size_t n : {1U, 2U, 9U, 200U, 1003U}) {
    const Residuals data(n);
    Array sorted;
    for (std::size_t i = 0; i < n; ++i) sorted.push_back(static_cast<float>(std::abs(data.e(i))));
    std::sort(sorted.begin(), sorted.end());
    const float most = 3.0F, exact_median = std::min(sorted[n / 2], most);
    float first = -1.0F;
    withEverySweepTarget([&] {
      Array scratch(n + kernels::overrun);
      const float median = kernels::medianDeviation(data.view(), most, scratch.data());
      ASSERT_NEAR(median, exact_median, most / 1024 + 1e-5F) << n;
      if (first < 0.0F) first = median;
      EXPECT_EQ(median, first);
    });
  }
}

}  // namespace
}  // namespace ipm_mapping
