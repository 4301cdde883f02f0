// The software part of the twin (rules 3, 4 and 10) against the oracle's: only the achieved error
// counts, the search may differ in the last bits of a double.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "fpga/oracle/generator.hpp"
#include "fpga/oracle/software.hpp"
#include "ipm_mapping/fpga/software_part.hpp"

namespace ipm_mapping::fpga {
namespace {

CameraModel twinCamera(const oracle::Camera& c) {
  const Intrinsics intrinsics{c.width,
                              c.height,
                              static_cast<double>(c.fx),
                              static_cast<double>(c.fy),
                              static_cast<double>(c.cx),
                              static_cast<double>(c.cy)};
  const Distortion distortion{static_cast<double>(c.k1), static_cast<double>(c.k2), 0.0, 0.0,
                              static_cast<double>(c.k3)};
  return {intrinsics, distortion};
}

GroundView twinView(const oracle::Camera& camera, const oracle::Motion& m) {
  GroundView view;
  view.camera = twinCamera(camera);
  view.T_base_camera = cameraPose(static_cast<double>(m.lead), 0.0, static_cast<double>(m.height),
                                  static_cast<double>(m.pitch));
  view.motion = {static_cast<double>(m.x), static_cast<double>(m.y), static_cast<double>(m.angle)};
  return view;
}

TEST(FpgaSoftwareOracle, TheQuantisedHomographyIsAsGoodAsAnIndependentSearchFinds) {
  double worst = 0.0, worst_excess = -1e9;
  int unusable = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const oracle::Camera camera = oracle::randomCamera(seed);
    const oracle::TwoViews views = oracle::twoViews(camera, oracle::randomMotion(seed));
    const oracle::Fit fit = oracle::fitHomography(camera, views);
    const auto twin = quantiseHomography(twinView(camera, oracle::randomMotion(seed)));
    ASSERT_EQ(twin.has_value(), fit.usable) << "seed " << seed;
    if (!fit.usable) {
      ++unusable;
      continue;
    }
    oracle::Coefficients words{};
    std::copy(twin->words.begin(), twin->words.end(), words.begin());
    const auto error =
        static_cast<double>(oracle::quantisationError(words, oracle::gridPoints(camera, views)));
    EXPECT_NEAR(twin->worst_error, error, 2e-6) << "seed " << seed;
    EXPECT_LE(error, static_cast<double>(fit.error) + 1e-4) << "seed " << seed;
    worst = std::max(worst, error);
    worst_excess = std::max(worst_excess, error - static_cast<double>(fit.error));
  }
  std::cout << "[  oracle  ] worst error " << worst << " px; worst excess over the oracle's search "
            << worst_excess << " px; unusable " << unusable << " of 40\n";
}

TEST(FpgaSoftwareOracle, HorizonAndCameraRegistersAreEqual) {
  for (uint64_t seed = 0; seed < 300; ++seed) {
    const oracle::Camera camera = oracle::randomCamera(seed);
    const oracle::Motion motion = oracle::randomMotion(seed);
    const auto horizon = oracle::horizonCoefficients(oracle::twoViews(camera, motion));
    const auto twin = quantiseHorizon(twinView(camera, motion));
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(twin[i], horizon[i]) << "seed " << seed << " " << i;
    FrameParameters p;
    ASSERT_FALSE(quantiseCamera(twinCamera(camera), p)) << "seed " << seed;
    const auto fixed = [](oracle::Real value, int one) { return std::llround(value * one); };
    EXPECT_EQ(p.fx, fixed(camera.fx, 64));
    EXPECT_EQ(p.fy, fixed(camera.fy, 64));
    EXPECT_EQ(p.cx, fixed(camera.cx, 64));
    EXPECT_EQ(p.cy, fixed(camera.cy, 64));
    EXPECT_EQ(p.k1, fixed(camera.k1, 2048));
    EXPECT_EQ(p.k2, fixed(camera.k2, 2048));
    EXPECT_EQ(p.k3, fixed(camera.k3, 2048));
    EXPECT_EQ(p.r2_max, oracle::r2Max(camera)) << "seed " << seed;
  }
}

/// Lenses whose turning radius is small, large, at a double root, or nowhere.
TEST(FpgaSoftwareOracle, TurningRadiusIsTheSmallestPositiveRoot) {
  oracle::Random random(5);
  for (int n = 0; n < 2000; ++n) {
    oracle::Camera camera;
    camera.k1 = static_cast<double>(random.real(-3.9L, 3.9L));
    camera.k2 = random.chance(20) ? 0 : static_cast<double>(random.real(-3.9L, 3.9L));
    camera.k3 = random.chance(20) ? 0 : static_cast<double>(random.real(-3.9L, 3.9L));
    if (random.chance(10)) camera.k1 = camera.k2 = 0;
    FrameParameters p;
    ASSERT_FALSE(quantiseCamera(twinCamera(camera), p)) << n;
    EXPECT_NEAR(static_cast<double>(p.r2_max), oracle::r2Max(camera), 1.0)
        << camera.k1 << " " << camera.k2 << " " << camera.k3;
  }
}

/// Equal, or one apart where the exact value is so near a step of rounding or truncation that a
/// double cannot tell the sides apart.
void expectComponent(int found, int expected, oracle::Real exact, const std::string& where) {
  const bool on_a_step = std::abs(2 * exact - std::round(2 * exact)) < 1e-6L;
  EXPECT_LE(std::abs(found - expected), on_a_step ? 1 : 0) << where << ": " << exact;
}

void expectSameFocus(const oracle::Vector& f, int width, int height, const std::string& where) {
  const oracle::Focus expected = oracle::focusWord(f, width, height);
  ipm_mapping::Focus focus;
  focus.f = {static_cast<double>(f[0]), static_cast<double>(f[1]), static_cast<double>(f[2])};
  const QuantisedFocus found = quantiseFocus(focus, width, height);
  ASSERT_EQ(found.usable, expected.usable) << where;
  if (!expected.usable) return;
  EXPECT_EQ(found.clamped, expected.clamped) << where;
  expectComponent(found.word.u, expected.u, expected.exact_u, where + " u");
  expectComponent(found.word.v, expected.v, expected.exact_v, where + " v");
}

oracle::Vector vectorOf(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

void expectNear(const Eigen::Vector3d& found, const oracle::Vector& f, const std::string& where) {
  for (size_t i = 0; i < 3; ++i) {
    const auto expected = static_cast<double>(f[i]);
    const double tolerance = 1e-12 * (1000.0 + std::abs(expected));
    EXPECT_NEAR(found[static_cast<int>(i)], expected, tolerance) << where;
  }
}

TEST(FpgaSoftwareOracle, FocusWordsOfRobotMotionsAreEqual) {
  for (uint64_t seed = 0; seed < 2000; ++seed) {
    const oracle::Camera camera = oracle::randomCamera(seed);
    oracle::Motion motion = oracle::randomMotion(seed);
    if (seed % 4 == 0) motion.pitch /= 1 << (seed % 64);  // towards a level camera
    if (seed % 9 == 0) motion.pitch = 0;
    const oracle::TwoViews views = oracle::twoViews(camera, motion);
    const VanishingPoints points = vanishingPoints(twinView(camera, motion));
    const std::string where = "seed " + std::to_string(seed);
    expectNear(points.f1, views.f1, where + " f1");
    expectNear(points.f2, views.f2, where + " f2");
    // From here on with the twin's own points: near a level camera f_w is all rounding error.
    const oracle::TwoViews same{{}, {}, {}, vectorOf(points.f1), vectorOf(points.f2)};
    expectNear(midFootFocus(points).f, oracle::midFoot(same), where);
    expectNear(meanPixelFocus(points).f, oracle::meanPixel(same), where + " paper");
    for (const auto& focus : {midFootFocus(points), meanPixelFocus(points)}) {
      expectSameFocus(vectorOf(focus.f), camera.width, camera.height, where);
    }
  }
}

/// Every branch of rule 10: rounding ties, both limits, all signs, f_w = 0, t_v <= 0, f_v near 0.
TEST(FpgaSoftwareOracle, FocusWordsOfArbitraryVectorsAreEqual) {
  oracle::Random random(11);
  int clamped = 0, unusable = 0, fits = 0;
  for (int n = 0; n < 200000; ++n) {
    const int width = random.in(1, 640), height = random.in(1, 480);
    const double w = random.pick({0, 0, 1, -1, 2, -2, random.in(-64, 64)}) /
                     static_cast<double>(random.pick({1, 1, 64, 4096}));
    const auto coordinate = [&] {
      return static_cast<double>(
                 random.pick({0, 1, -1, 8191, -8192, 8192, random.in(-20000, 20000)})) +
             0.25 * random.in(-4, 4);
    };
    const double scale = w == 0.0 ? 1.0 : w;
    const oracle::Vector f{coordinate() * scale, coordinate() * scale, w};
    expectSameFocus(f, width, height, "case " + std::to_string(n));
    if (testing::Test::HasFailure()) return;
    const oracle::Focus expected = oracle::focusWord(f, width, height);
    unusable += expected.usable ? 0 : 1;
    clamped += expected.usable && expected.clamped ? 1 : 0;
    fits += expected.usable && !expected.clamped ? 1 : 0;
  }
  EXPECT_GT(clamped, 1000);
  EXPECT_GT(unusable, 1000);
  EXPECT_GT(fits, 1000);
}

void expectRegisters(const FpgaParameters& set, const FrameParameters& p) {
  EXPECT_EQ(p.paper_order, set.paper_order);
  EXPECT_EQ(p.undistort_current, set.undistort_current);
  EXPECT_EQ(p.use_horizon, set.use_horizon);
  EXPECT_EQ(p.min_threshold, set.min_threshold);
  EXPECT_EQ(p.method, set.method == ContactMethod::Triangle ? 1 : 0);
  EXPECT_EQ(p.score_min, set.score_min);
  EXPECT_EQ(p.min_height, set.min_height);
  EXPECT_EQ(p.single_bin_peaks, set.single_bin_peaks);
  EXPECT_EQ(p.valley_threshold, set.valley_threshold);
  EXPECT_EQ(p.free_space_rule, set.free_space_rule == FreeSpaceRule::DeepValley ? 0 : 1);
  EXPECT_EQ(p.bearing_tolerance, set.bearing_tolerance);
  EXPECT_EQ(p.memory_rows, std::clamp<Integer>(set.memory_rows, p.height, 524288 / p.width));
  EXPECT_NO_THROW(validate(p));
}

/// Every switch away from its default, so that none can be forgotten on the way to its register.
FpgaParameters otherParameters() {
  FpgaParameters set = FpgaParameters::paper();
  set.paper_order = true;
  set.undistort_current = set.use_horizon = false;
  set.method = ContactMethod::Score;
  set.free_space_rule = FreeSpaceRule::Printed;
  set.memory_rows = 500;
  set.score_min = 7;
  set.min_height = 9;
  set.valley_threshold = 3;
  set.bearing_tolerance = 2;
  return set;
}

TEST(FpgaSoftwareOracle, SetupLoadsEveryRegisterOfAFrame) {
  std::array<int, 3> seen{};
  for (uint64_t seed = 0; seed < 32; ++seed) {
    const oracle::Camera camera = oracle::randomCamera(seed);
    oracle::Motion motion = oracle::randomMotion(seed);
    if (seed % 8 == 1) motion.angle = 2.5L;   // no common floor
    if (seed % 8 == 2) motion.pitch = -1.7L;  // the feet lie over the image
    const FpgaParameters set = seed % 2 == 0 ? FpgaParameters{} : otherParameters();
    SoftwarePart part(set);
    ASSERT_FALSE(part.setCamera(twinCamera(camera)));
    const auto found = part.setup(twinView(camera, motion), static_cast<uint8_t>(seed));
    const oracle::TwoViews views = oracle::twoViews(camera, motion);
    const oracle::Fit fit = oracle::fitHomography(camera, views);
    const oracle::Focus focus =
        oracle::focusWord(set.mean_pixel_focus ? oracle::meanPixel(views) : oracle::midFoot(views),
                          camera.width, camera.height);
    ++seen[static_cast<size_t>(found.status)];
    ASSERT_EQ(found.status == SetupStatus::Ok, fit.usable && focus.usable) << "seed " << seed;
    if (found.status != SetupStatus::Ok) continue;
    const FrameParameters& p = found.parameters;
    expectRegisters(set, p);
    EXPECT_EQ(p.threshold_in, static_cast<Integer>(seed));
    EXPECT_EQ(found.focus_clamped, focus.clamped);
    EXPECT_NEAR(static_cast<double>(p.focus_u), focus.u, 1.0);
    EXPECT_NEAR(static_cast<double>(p.focus_v), focus.v, 1.0);
    EXPECT_LE(found.homography_error, static_cast<double>(fit.error) + 1e-4) << "seed " << seed;
    const auto horizon = oracle::horizonCoefficients(views);
    EXPECT_EQ((std::array<Integer, 3>{p.horizon_a, p.horizon_b, p.horizon_c}),
              (std::array<Integer, 3>{horizon[0], horizon[1], horizon[2]}));
  }
  EXPECT_GT(seen[static_cast<size_t>(SetupStatus::Ok)], 16);
  EXPECT_GT(seen[static_cast<size_t>(SetupStatus::HomographyUnusable)], 0);
}

}  // namespace
}  // namespace ipm_mapping::fpga
