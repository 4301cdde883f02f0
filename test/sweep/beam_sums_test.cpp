#include "ipm_mapping/sweep/beam_sums.hpp"

#include <gtest/gtest.h>

#include <random>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {
namespace {

class Patches : public ::testing::Test {
 protected:
  static constexpr int rows = 60, lines = 40;

  void SetUp() override {
    plane.resize(rows, lines);
    for (int line = 0; line < lines; ++line)
      for (int row = 0; row < rows; ++row)
        plane.at(row, line) = static_cast<std::int16_t>(grey(random));
  }
  /// Grey level between rows and lines.
  [[nodiscard]] double at(double row, double line) const {
    const int j = static_cast<int>(row), l = static_cast<int>(line);
    const double a = row - j, b = line - l;
    const int next_row = a > 0 ? j + 1 : j, next_line = b > 0 ? l + 1 : l;
    return (1 - b) * ((1 - a) * plane.at(j, l) + a * plane.at(next_row, l)) +
           b * ((1 - a) * plane.at(j, next_line) + a * plane.at(next_row, next_line));
  }
  [[nodiscard]] double expected(const BeamPatch& p) const {
    double sum = 0.0;
    for (int row = p.begin; row < p.end; ++row)
      for (int k = 0; k < kernels::beam_lines; ++k)
        sum += at(row + p.row + p.row_fraction / 32768.0, p.line + k + p.line_fraction / 32768.0);
    return sum;
  }

  std::mt19937 random{7};
  std::uniform_int_distribution<int> grey{-1000, 8160};
  Image<std::int16_t> plane;
};

TEST_F(Patches, AreSummedBetweenRowsAndLines) {
  BeamSums sums;
  sums.configure(rows, lines);
  sums.evaluate(plane.view());
  for (const BeamPatch& p : {BeamPatch{3, 30, 5, 0, 0, 0}, BeamPatch{10, 14, 0, 20000, -7, 9000},
                             BeamPatch{0, 20, 31, 32767, 39, 16384}, BeamPatch{8, 9, 17, 1, 2, 1}})
    EXPECT_NEAR(sumOf(sums.view(), p), expected(p), 4.0) << p.begin << ' ' << p.line;
}

TEST_F(Patches, OfEveryStepthLineBeginThere) {
  BeamSums every, some;
  every.configure(rows, lines);
  some.configure(rows, lines, 6);
  every.evaluate(plane.view());
  some.evaluate(plane.view());
  ASSERT_EQ(some.view().height, 6) << "lines 0, 6 ... 30";
  for (int beam = 0; beam < some.view().height; ++beam)
    for (int row = 0; row <= rows; ++row)
      EXPECT_EQ(some.view().at(row, beam), every.view().at(row, 6 * beam));
}

TEST_F(Patches, OfAPlaneNarrowerThanABeamAreNone) {
  for (const int step : {1, 6}) {
    BeamSums sums;
    sums.configure(rows, kernels::beam_lines - 1, step);
    sums.evaluate({plane.row(0), rows, kernels::beam_lines - 1, plane.view().stride});
    EXPECT_EQ(sums.view().height, 0);
  }
}

}  // namespace
}  // namespace ipm_mapping::sweep
