#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/kernels/floor_residual.hpp"
#include "ipm_mapping/kernels/sweep_rectify.hpp"
#include "ipm_mapping/kernels/sweep_sums.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "kernels/sweep_targets.hpp"

namespace ipm_mapping {
namespace {

using test::withEverySweepTarget;

template <class T>
std::vector<T> randomValues(std::size_t count, int low, int high, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> value(low, high);
  std::vector<T> values(count);
  for (T& v : values) v = static_cast<T>(value(random));
  return values;
}

constexpr int counts[] = {1, 5, 16, 37, 112};

/// t^2 as the header defines it, in plain integers.
int squaredDeviation(int difference, int weight) {
  const int t = std::min(static_cast<int>((static_cast<long>(std::abs(difference)) * weight) >> 16),
                         kernels::deviation_cap);
  return t * t;
}

TEST(SweepCostKernels, SplittingAppliesGainAndOffsetToBothParities) {
  const auto line = randomValues<std::uint8_t>(300, 0, 255, 1);
  for (const int count : counts) {
    for (const auto& [gain, offset] :
         {std::pair{16384, 0}, {8192, 511}, {20000, -900001}, {24000, 900257}}) {
      withEverySweepTarget([&, n = count, g = gain, o = offset] {
        std::vector<std::int16_t> even(200), odd(200);
        kernels::splitRows(line.data(), g, o, n, even.data(), odd.data());
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
          const auto expected = [&](int byte) {
            return std::clamp(static_cast<int>(std::floor((g * byte + o) / 512.0)), -8191, 8191);
          };
          ASSERT_EQ(even[i], expected(line[2 * i]));
          ASSERT_EQ(odd[i], expected(line[2 * i + 1]));
        }
      });
    }
  }
}

TEST(SweepCostKernels, AGainOfOneKeepsGreyLevelsInTheirUnit) {
  std::vector<std::uint8_t> line{0, 1, 128, 255};
  line.resize(line.size() + 2 * kernels::overrun);
  std::vector<std::int16_t> even(2 + kernels::overrun), odd(even.size());
  kernels::splitRows(line.data(), 16384, 0, 2, even.data(), odd.data());
  EXPECT_EQ(even[1], 128 * kernels::grey_unit);
  EXPECT_EQ(odd[1], 255 * kernels::grey_unit);
}

TEST(SweepCostKernels, NoiseWeightIsTheInverseStandardDeviation) {
  std::vector<std::vector<std::int16_t>> planes;  // here, left, right, far, near
  for (unsigned seed = 2; seed < 7; ++seed) {
    planes.push_back(randomValues<std::int16_t>(200, 0, 255, seed));
    for (auto& grey : planes.back()) grey = static_cast<std::int16_t>(grey * kernels::grey_unit);
  }
  const kernels::NoiseNeighbours grey{planes[0].data(), planes[1].data(), planes[2].data(),
                                      planes[3].data(), planes[4].data()};
  const kernels::NoiseTerms terms{0.34F, 0.009F, 0.08F, 0.3F};
  const std::vector<float> along(200, 0.05F), bend(200, 0.2F);
  std::vector<std::uint16_t> first;
  for (const int count : counts) {
    first.clear();
    withEverySweepTarget([&, n = count] {
      std::vector<std::uint16_t> weight(200);
      kernels::noiseWeights(grey, along.data(), bend.data(), terms, n, weight.data());
      weight.resize(static_cast<std::size_t>(n));
      for (std::size_t i = 0; i < weight.size(); ++i) {
        const auto at = [&](std::size_t plane) { return planes[plane][i] / 32.0; };
        const double dl = at(2) - at(1), dr = at(4) - at(3);
        const double L = 0.3 * (at(2) + at(1) - 2.0 * at(0)) + 0.2 * (at(4) + at(3) - 2.0 * at(0));
        const double variance = 0.34 + 0.009 * at(0) + 0.08 * dl * dl + 0.05 * dr * dr + L * L;
        const double expected = 32768.0 / std::sqrt(std::max(variance, 0.26));
        ASSERT_NEAR(weight[i], expected, 1.0 + 1e-4 * expected) << i;
      }
      if (first.empty()) first = weight;
      EXPECT_EQ(weight, first);
    });
  }
}

/// An image of noise, lines of `rows` pixels, and what a path through it reads.
struct PathCase {
  static constexpr int rows = 120, lines = 30, count = 128;
  Image<std::uint8_t> image{rows, lines};
  Image<std::uint16_t> pairs{rows, lines};
  std::vector<std::int32_t> row = randomValues<std::int32_t>(count, 0, (rows - 2) * 64, 6);
  std::vector<std::int32_t> line = randomValues<std::int32_t>(count, 0, (lines - 2) * 64, 7);
  std::vector<std::int16_t> current = randomValues<std::int16_t>(count, 0, 8160, 8);

  PathCase() {
    const auto bytes = randomValues<std::uint8_t>(rows * lines, 0, 255, 5);
    std::copy(bytes.begin(), bytes.end(), image.row(0));
    kernels::pairRows(image.view(), pairs.view());
  }
  [[nodiscard]] std::vector<std::int16_t> residual(int gain, int offset, int n) const {
    std::vector<std::int16_t> out(count);
    kernels::pathResidual(pairs.view(), row.data(), line.data(), gain, offset, current.data(), n,
                          out.data());
    return out;
  }
};

TEST(SweepCostKernels, PathResidualIsCurrentMinusBrightenedBilinearSample) {
  const PathCase data;
  const int gain = 17000, offset = -30000;
  for (const int count : counts) {
    withEverySweepTarget([&, n = count] {
      const std::vector<std::int16_t> residual = data.residual(gain, offset, n);
      for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
        const int row = data.row[i] / 64, line = data.line[i] / 64;
        const double a = (data.row[i] % 64) / 64.0, b = (data.line[i] % 64) / 64.0;
        const std::uint8_t *p = data.image.row(line) + row, *q = data.image.row(line + 1) + row;
        const double sample =
            (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1]);
        const double expected =
            data.current[i] - 32.0 * (gain / 16384.0 * sample + offset / 16384.0);
        ASSERT_NEAR(residual[i], expected, 2.1) << i;  // two roundings down, one of them amplified
      }
    });
  }
}

TEST(SweepCostKernels, PathResidualIsTheSameOnEveryTarget) {
  const PathCase data;
  std::vector<std::int16_t> first;
  withEverySweepTarget([&] {
    const std::vector<std::int16_t> residual = data.residual(15000, 2000, 112);
    if (first.empty()) first = residual;
    EXPECT_EQ(residual, first);
  });
}

TEST(SweepCostKernels, MeanOfAWindowIsThatOfTheResidualsInIt) {
  const int rows = 40, half = 3;
  const auto lines = randomValues<std::int16_t>(3 * rows, -900, 900, 13);
  // a line that is taken away again, and two that are there on different rows
  const int begin[] = {0, 2, 5}, end[] = {40, 20, 33};
  withEverySweepTarget([&] {
    std::vector<std::int32_t> sum(rows + 2 * half + kernels::overrun), number(sum.size());
    const auto accumulate = [&](int line, int sign) {
      kernels::accumulateResidual(lines.data() + line * rows + begin[line], sign,
                                  end[line] - begin[line], sum.data() + half + begin[line],
                                  number.data() + half + begin[line]);
    };
    for (const int line : {0, 1, 2}) accumulate(line, 1);
    accumulate(0, -1);
    std::vector<std::int16_t> mean(rows + kernels::overrun);
    std::vector<std::int32_t> sums(sum.size() + 1), numbers(sums.size());
    kernels::prefixSums(sum.data(), rows + 2 * half, sums.data());
    kernels::prefixSums(number.data(), rows + 2 * half, numbers.data());
    kernels::windowMean(sums.data(), numbers.data(), 2 * half + 1, rows, mean.data());
    for (int i = 0; i < rows; ++i) {
      double total = 0.0;
      int there = 0;
      for (const int line : {1, 2})
        for (int k = std::max(begin[line], i - half); k < std::min(end[line], i + half + 1); ++k)
          total += lines[static_cast<std::size_t>(line * rows + k)], ++there;
      const double expected = there == 0 ? 0.0 : total / there;
      ASSERT_NEAR(mean[static_cast<std::size_t>(i)], expected, 1.0) << i;
    }
  });
}

TEST(SweepCostKernels, FloorCostTakesTheKinderOfPlainAndDriftingResidual) {
  const auto residual = randomValues<std::int16_t>(112, -3000, 3000, 14);
  const auto mean = randomValues<std::int16_t>(112, -3000, 3000, 15);
  const auto weight = randomValues<std::uint16_t>(112, 0, 60000, 16);
  for (const int count : counts) {
    withEverySweepTarget([&, n = count] {
      std::vector<std::uint16_t> squares(128, 100), cost(128, 100);
      kernels::squaredFloorDeviation(residual.data(), mean.data(), weight.data(), n,
                                     squares.data());
      kernels::addSquares(squares.data(), n, cost.data());
      for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
        const int e = std::min(std::abs(residual[i]), std::abs(residual[i] - mean[i]));
        ASSERT_EQ(squares[i], squaredDeviation(e, weight[i])) << i;
        ASSERT_EQ(cost[i], 100 + squares[i]) << i;
      }
      EXPECT_EQ(squares[static_cast<std::size_t>(n)], 100);
      EXPECT_EQ(cost[static_cast<std::size_t>(n)], 100);
    });
  }
}

TEST(SweepCostKernels, LoweringNeverRaisesAndNeverInvents) {
  const std::vector<std::uint16_t> other{100, 900, 0, 18432};
  std::vector<std::uint16_t> cost{500, 500, kernels::no_cost, 5000};
  kernels::lowerTo(other.data(), 50, 4, cost.data());
  EXPECT_EQ(cost, (std::vector<std::uint16_t>{150, 500, kernels::no_cost, 5000}));
}

TEST(SweepCostKernels, EvidenceIsTheCappedFloorMinusTheVertical) {
  const auto floor = randomValues<std::uint16_t>(112, 0, 18432, 17);
  const auto vertical = randomValues<std::uint16_t>(112, 0, 18432, 18);
  const auto weight = randomValues<std::int32_t>(112, 20, 1300, 19);
  for (const int count : counts) {
    withEverySweepTarget([&, n = count] {
      auto seen = floor;
      seen[0] = kernels::no_cost;
      std::vector<std::int32_t> evidence(128, 10);
      kernels::accumulateEvidence(seen.data(), vertical.data(), weight.data(), 5120, 102, n,
                                  evidence.data());
      EXPECT_EQ(evidence[0], 10) << "an unseen row says nothing";
      for (std::size_t i = 1; i < static_cast<std::size_t>(n); ++i) {
        const double gain = std::min<int>(floor[i], 5120) - static_cast<int>(vertical[i]) - 102;
        ASSERT_EQ(evidence[i], 10 + static_cast<int>(std::floor(gain * weight[i] / 256.0))) << i;
      }
    });
  }
}

TEST(SweepCostKernels, BlockSumsAddEightBytes) {
  const auto bytes = randomValues<std::uint8_t>(8 * 37, 0, 255, 20);
  withEverySweepTarget([&] {
    std::vector<std::int32_t> sums(37, 5);
    kernels::addBlockSums(bytes.data(), 37, sums.data());
    for (std::size_t b = 0; b < 37; ++b) {
      int expected = 5;
      for (std::size_t k = 0; k < 8; ++k) expected += bytes[8 * b + k];
      ASSERT_EQ(sums[b], expected);
    }
  });
}

TEST(SweepCostKernels, NodesBetweenTwoLinesAreBlends) {
  const auto a = randomValues<std::int32_t>(112, -400000, 400000, 27);
  const auto b = randomValues<std::int32_t>(112, -400000, 400000, 28);
  for (const int count : counts) {
    withEverySweepTarget([&, n = count] {
      std::vector<std::int32_t> out(112, 7);
      kernels::blendNodes(a.data(), b.data(), 3, n, out.data());
      for (std::size_t i = 0; i < out.size(); ++i) {
        const bool inside = i < static_cast<std::size_t>(n);
        ASSERT_EQ(out[i], inside ? static_cast<int>((5.0 * a[i] + 3.0 * b[i]) / 8.0) : 7) << i;
      }
    });
  }
}

TEST(SweepCostKernels, NodesAreJoinedByStraightLines) {
  const std::vector<std::int32_t> nodes{1024, 9216, -5120};
  withEverySweepTarget([&] {
    std::vector<std::int32_t> out(16);
    kernels::interpolateNodes(nodes.data(), 2, out.data());
    for (int i = 0; i < 16; ++i) {
      const double t = i % 8 / 8.0;
      const auto b = static_cast<std::size_t>(i / 8);
      const double expected = ((1 - t) * nodes[b] + t * nodes[b + 1]) / 16.0;
      ASSERT_NEAR(out[static_cast<std::size_t>(i)], expected, 1.0) << i;
    }
  });
}

/// Eight lines of noise in the current view; the reference shows them moved by a fraction.
struct VerticalCase {
  static constexpr int stride = 150;
  std::vector<std::int16_t> current = randomValues<std::int16_t>(stride * 9, 0, 8160, 21);
  std::vector<std::int16_t> upper = randomValues<std::int16_t>(stride * 10, -8000, 8160, 22);
  std::vector<std::int16_t> lower = randomValues<std::int16_t>(stride * 10, -8000, 8160, 23);
  std::vector<std::uint16_t> weight = randomValues<std::uint16_t>(stride * 9, 200, 60000, 24);

  [[nodiscard]] kernels::VerticalPath path(double row_fraction, double line_fraction) const {
    kernels::VerticalPath p;
    p.current = current.data();
    p.weight = weight.data();
    p.stride = stride;
    p.upper = upper.data();
    p.lower = lower.data();
    p.row_fraction = static_cast<std::int16_t>(row_fraction * 32767);
    p.line_fraction = static_cast<std::int16_t>(line_fraction * 32767);
    return p;
  }
  /// Grey level of the reference between rows and lines, in exact arithmetic.
  [[nodiscard]] double seen(int k, int i, double a, double b) const {
    const auto blend = [&](int line) {
      const auto at = static_cast<std::size_t>(line * stride + i);
      return upper[at] + a * (lower[at] - upper[at]);
    };
    return blend(k) + b * (blend(k + 1) - blend(k));
  }
};

TEST(SweepCostKernels, VerticalCostSumsEightInterpolatedLines) {
  const VerticalCase data;
  for (const double a : {0.0, 0.3, 0.99}) {
    for (const double b : {0.0, 0.7}) {
      withEverySweepTarget([&] {
        std::vector<std::uint16_t> cost(112 + kernels::overrun);
        kernels::verticalCost(data.path(a, b), 112, cost.data());
        for (int i = 0; i < 112; ++i) {
          double low = 0, high = 0;  // the fixed point may be off by three units
          for (int k = 0; k < kernels::beam_lines; ++k) {
            const auto at = static_cast<std::size_t>(k * VerticalCase::stride + i);
            const double e = std::abs(data.current[at] - data.seen(k, i, a, b));
            const auto t = [&](double x) {
              return std::clamp(std::floor(x * data.weight[at] / 65536.0), 0.0, 48.0);
            };
            low += t(e - 3) * t(e - 3);
            high += t(e + 3) * t(e + 3);
          }
          const int got = cost[static_cast<std::size_t>(i)];
          ASSERT_GE(got, low) << i;
          ASSERT_LE(got, high) << i;
        }
      });
    }
  }
}

TEST(SweepCostKernels, ABrighterSurfaceIsComparedAsIfItWereNot) {
  VerticalCase data;
  kernels::VerticalPath brighter = data.path(0.41, 0.83);
  brighter.brighter = 37;
  VerticalCase darker = data;
  for (std::int16_t& grey : darker.current) grey = static_cast<std::int16_t>(grey - 37);
  withEverySweepTarget([&] {
    std::vector<std::uint16_t> cost(97 + kernels::overrun), expected(cost.size());
    kernels::verticalCost(brighter, 97, cost.data());
    kernels::verticalCost(darker.path(0.41, 0.83), 97, expected.data());
    cost.resize(97), expected.resize(97);
    EXPECT_EQ(cost, expected);
  });
}

TEST(SweepCostKernels, LinesAreAddedToAColumnAndTakenOutOfIt) {
  const auto line = randomValues<std::int16_t>(64, -8191, 8191, 41);
  for (const int count : {0, 1, 31, 64}) {
    withEverySweepTarget([&] {
      std::vector<std::int32_t> column(static_cast<std::size_t>(count) + 1, 100000);
      kernels::addLineTo(line.data(), 1, count, column.data());
      for (int i = 0; i < count; ++i)
        ASSERT_EQ(column[static_cast<std::size_t>(i)], 100000 + line[static_cast<std::size_t>(i)]);
      kernels::addLineTo(line.data(), -1, count, column.data());
      for (const std::int32_t value : column) EXPECT_EQ(value, 100000);
    });
  }
}

TEST(SweepCostKernels, PrefixSumsAreOfWhatLiesBeforeEachRow) {
  const auto column = randomValues<std::int32_t>(64, -65528, 65528, 42);
  for (const int count : {0, 1, 3, 4, 31, 64}) {
    withEverySweepTarget([&] {
      std::vector<std::int32_t> sums(static_cast<std::size_t>(count) + 2, -1);
      kernels::prefixSums(column.data(), count, sums.data());
      std::int32_t expected = 0;
      for (int i = 0; i <= count; ++i) {
        ASSERT_EQ(sums[static_cast<std::size_t>(i)], expected) << i;
        expected += column[static_cast<std::size_t>(i) % 64];
      }
      EXPECT_EQ(sums.back(), -1) << "written past the end";
    });
  }
}

TEST(SweepCostKernels, VerticalCostIsTheSameOnEveryTarget) {
  const VerticalCase data;
  std::vector<std::uint16_t> first;
  withEverySweepTarget([&] {
    std::vector<std::uint16_t> cost(97 + kernels::overrun);
    kernels::verticalCost(data.path(0.41, 0.83), 97, cost.data());
    cost.resize(97);
    if (first.empty()) first = cost;
    EXPECT_EQ(cost, first);
  });
}

/// Two references that see different rows of a support; what lies above `reach` looks like floor.
struct SupportCase {
  static constexpr int rows = 100;
  VerticalCase images;
  std::vector<std::uint16_t> floor = randomValues<std::uint16_t>(160, 0, 9000, 25);
  std::vector<std::int32_t> weight = randomValues<std::int32_t>(160, 20, 1300, 26);
  std::vector<std::int32_t> potential = std::vector<std::int32_t>(160, 0);
  std::vector<kernels::EvidencePath> paths;

  SupportCase() {
    for (std::size_t j = 20; j < 25; ++j) floor[j] = kernels::no_cost;
    // costs of a vertical line that mostly fits: small weights
    for (auto& w : images.weight) w = static_cast<std::uint16_t>(w / 64);
    paths.push_back({images.path(0.3, 0.6), floor.data(), 5, 96});
    paths.push_back({images.path(0.8, 0.1), floor.data(), 11, 63});
    for (std::size_t j = 1; j < potential.size(); ++j)
      potential[j] = potential[j - 1] + 2 * 9000 * weight[j - 1] / 256;
  }
  [[nodiscard]] kernels::EvidenceTerms terms() const {
    return {weight.data(), potential.data(), 5120, 102};
  }
  /// Row by row, by the two kernels that climbSupport() is made of.
  [[nodiscard]] kernels::Climb oneByOne(int begin, int end) const {
    std::vector<std::int32_t> evidence(160, 0);
    for (const kernels::EvidencePath& p : paths) {
      std::vector<std::uint16_t> cost(160);
      kernels::verticalCost(p.vertical, 112, cost.data());
      kernels::accumulateEvidence(floor.data() + p.begin, cost.data() + p.begin,
                                  weight.data() + p.begin, 5120, 102, p.end - p.begin,
                                  evidence.data() + p.begin);
    }
    kernels::Climb climb;
    climb.best_row = end - 1;
    for (int j = end - 1; j >= begin; --j) {
      climb.sum += evidence[static_cast<std::size_t>(j)];
      if (climb.sum > climb.best) climb.best = climb.sum, climb.best_row = j;
    }
    return climb;
  }
};

TEST(SweepCostKernels, ClimbingASupportFindsTheHighestSumOfItsRows) {
  const SupportCase data;
  SupportCase hopeful;  // never over before the end
  for (std::size_t j = 0; j < hopeful.potential.size(); ++j)
    hopeful.potential[j] = static_cast<std::int32_t>(j << 22);
  for (const auto& [begin, end] :
       {std::pair{0, 100}, {8, 97}, {30, 62}, {40, 43}, {90, 100}, {50, 58}}) {
    withEverySweepTarget([&, b = begin, e = end] {
      const kernels::Climb expected = data.oneByOne(b, e);
      kernels::Climb climb;
      climb.best_row = e - 1;
      kernels::climbSupport(data.paths.data(), 2, data.terms(), b, e, b, 0, climb);
      EXPECT_EQ(climb.best, expected.best);
      EXPECT_EQ(climb.best_row, expected.best_row);
      climb = {};
      climb.best_row = e - 1;
      kernels::climbSupport(hopeful.paths.data(), 2, hopeful.terms(), b, e, b, 0, climb);
      EXPECT_EQ(climb.best, expected.best);
      EXPECT_EQ(climb.best_row, expected.best_row);
      EXPECT_EQ(climb.sum, expected.sum);
    });
  }
}

TEST(SweepCostKernels, ClimbingIsOverWhenNothingAboveCanHelp) {
  SupportCase data;
  kernels::Climb climb;
  kernels::climbSupport(data.paths.data(), 2, data.terms(), 64, 96, 0, 0, climb);
  EXPECT_FALSE(climb.over);
  climb = {};
  kernels::climbSupport(data.paths.data(), 2, data.terms(), 64, 96, 0, 1 << 30, climb);
  EXPECT_TRUE(climb.over) << "not even everything above makes `least`";
  climb = {};
  std::fill(data.potential.begin(), data.potential.end(), 0);
  kernels::climbSupport(data.paths.data(), 2, data.terms(), 64, 96, 0, 0, climb);
  EXPECT_EQ(climb.over, climb.sum <= climb.best);
  EXPECT_TRUE(climb.over);
}

}  // namespace
}  // namespace ipm_mapping
