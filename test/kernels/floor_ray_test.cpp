#include "ipm_mapping/kernels/floor_ray.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "kernels/sweep_targets.hpp"

namespace ipm_mapping {
namespace {

using test::withEverySweepTarget;

constexpr int count = 333;  // no multiple of any vector

kernels::FloorRay rayTowards(double angle, double tx, double ty) {
  kernels::FloorRay ray;
  ray.ux = static_cast<float>(std::cos(angle));
  ray.uy = static_cast<float>(std::sin(angle));
  ray.tx = static_cast<float>(tx);
  ray.ty = static_cast<float>(ty);
  ray.rows_per_log = 200.0F;
  ray.lines_per_radian = 390.0F;
  ray.line_ahead = 311.5F;
  return ray;
}

std::vector<float> inverseDistances() {
  std::vector<float> inverse(count + kernels::overrun, 1.0F);
  for (int i = 0; i < count; ++i)
    inverse[static_cast<std::size_t>(i)] = 0.05F + 0.02F * static_cast<float>(i);
  return inverse;
}

/// (angle of the ray, motion) with points ahead, beside, behind and around the other view's foot.
const std::vector<kernels::FloorRay>& rays() {
  static const std::vector<kernels::FloorRay> all = [] {
    std::vector<kernels::FloorRay> rays;
    for (double angle = -M_PI; angle < M_PI; angle += 0.37)
      for (const double tx : {-0.31, 0.0, 0.17}) rays.push_back(rayTowards(angle, tx, -0.02 + tx));
    return rays;
  }();
  return all;
}

TEST(FloorRay, PositionsAreThoseOfTheFloorPointsSeenFromTheOtherFoot) {
  const std::vector<float> inverse = inverseDistances();
  withEverySweepTarget([&] {
    std::vector<float> line(inverse.size()), shift(inverse.size());
    for (const kernels::FloorRay& ray : rays()) {
      kernels::rayPositions(ray, inverse.data(), count, line.data(), shift.data());
      for (std::size_t i = 0; i < count; ++i) {
        // as they are rounded: what is tested is the arithmetic, not its inputs
        const double d = 1.0 / static_cast<double>(inverse[i]);
        const double x = static_cast<double>(ray.ux) * d + static_cast<double>(ray.tx);
        const double y = static_cast<double>(ray.uy) * d + static_cast<double>(ray.ty);
        if (std::hypot(x, y) < 0.05 * d) continue;  // the foot itself has no direction
        ASSERT_NEAR(shift[i], -200.0 * std::log(std::hypot(x, y) / d), 0.002) << i;
        const double turn = std::remainder((311.5 - line[i]) / 390.0 - std::atan2(y, x), 2 * M_PI);
        ASSERT_NEAR(390.0 * turn, 0.0, 0.002) << i;
      }
    }
  });
}

TEST(FloorRay, EveryTargetGivesTheSameBits) {
  const std::vector<float> inverse = inverseDistances();
  std::vector<float> first;
  withEverySweepTarget([&] {
    std::vector<float> all, line(inverse.size()), shift(inverse.size());
    for (const kernels::FloorRay& ray : rays()) {
      kernels::rayPositions(ray, inverse.data(), count, line.data(), shift.data());
      all.insert(all.end(), line.begin(), line.begin() + count);
      all.insert(all.end(), shift.begin(), shift.begin() + count);
    }
    if (first.empty()) first = all;
    ASSERT_EQ(all, first);
  });
}

TEST(FloorRay, TheOtherFootItselfIsAFinitePlace) {
  std::vector<float> inverse(1 + kernels::overrun, 2.0F), line(inverse.size()),
      shift(inverse.size());
  const kernels::FloorRay ray = rayTowards(0.0, -0.5, 0.0);
  withEverySweepTarget([&] {
    kernels::rayPositions(ray, inverse.data(), 1, line.data(), shift.data());
    EXPECT_TRUE(std::isfinite(line[0]));
    EXPECT_TRUE(std::isfinite(shift[0]));
  });
}

TEST(FloorRay, SplitRoundsDownAndTheFractionMakesItWholeAgain) {
  std::vector<float> position;
  for (int i = 0; i < count; ++i) position.push_back(-55.0F + 0.337F * static_cast<float>(i));
  for (const float whole : {-3.0F, 0.0F, 7.0F, -1e-6F, 6.9999995F}) position.push_back(whole);
  const int n = static_cast<int>(position.size());
  position.resize(position.size() + kernels::overrun);
  withEverySweepTarget([&] {
    std::vector<std::int32_t> whole(position.size()), fraction(position.size());
    kernels::splitPositions(position.data(), n, whole.data(), fraction.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      ASSERT_EQ(whole[i], static_cast<std::int32_t>(std::floor(position[i]))) << position[i];
      ASSERT_GE(fraction[i], 0);
      ASSERT_LE(fraction[i], std::numeric_limits<std::int16_t>::max());
      ASSERT_NEAR(whole[i] + fraction[i] / 32767.0, static_cast<double>(position[i]), 1.0 / 16384);
    }
  });
}

}  // namespace
}  // namespace ipm_mapping
