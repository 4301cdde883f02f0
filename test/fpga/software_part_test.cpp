#include "ipm_mapping/fpga/software_part.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "fpga/support.hpp"

namespace ipm_mapping::fpga {
namespace {

CameraModel camera(double focal = 525.0, Distortion d = {0.12, -0.25, 0.0, 0.0, 0.0}) {
  return CameraModel({640, 480, focal, focal, 319.5, 239.5}, d);
}

GroundView drive(double forward, double left, double turn, double pitch, double height = 0.3) {
  GroundView view;
  view.camera = camera();
  view.T_base_camera = cameraPose(0.1, 0.0, height, pitch);
  view.motion = {forward, left, turn};
  return view;
}

GroundView randomDrive(test::Generator& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  return drive(0.02 + 0.15 * unit(random), 0.1 * (unit(random) - 0.5), 0.3 * (unit(random) - 0.5),
               0.15 + 0.6 * unit(random), 0.25 + 0.5 * unit(random));
}

Eigen::Matrix3d matrixOf(const HomographyWords& words) {
  Eigen::Matrix3d h;
  for (int i = 0; i < 9; ++i) {
    h(i / 3, i % 3) = words[static_cast<std::size_t>(i)] / (i % 3 == 2 ? 128.0 : 2048.0);
  }
  return h;
}

/// Worst distance over the grid, straight from rule 3.
double worstError(const HomographyWords& words, const GroundView& view) {
  const Eigen::Matrix3d G = view.G(), h = matrixOf(words);
  const Eigen::Matrix3d to_floor = view.H_c().inverse();
  double worst = 0.0;
  for (int j = 0; j <= 12; ++j) {
    for (int i = 0; i <= 16; ++i) {
      const Eigen::Vector3d p(i * 639 / 16, j * 479 / 12, 1.0);
      const Eigen::Vector3d g = G * p, q = h * p;
      if (!((to_floor * p).z() > 0.0) || !(g.z() > 0.0)) continue;
      const auto seen = [&view](double u, double v) {
        double x = 0, y = 0;
        return view.camera.distortPixel(u, v, x, y) && x >= -0.5 && x < 639.5 && y >= -0.5 &&
               y < 479.5;
      };
      if (!seen(p.x(), p.y()) || !seen(g.x() / g.z(), g.y() / g.z())) continue;
      worst = std::max(worst, (q.hnormalized() - g.hnormalized()).norm());
    }
  }
  return worst;
}

TEST(HomographyQuantiser, ReportsTheErrorItAchieved) {
  test::Generator random(1);
  for (int round = 0; round < 30; ++round) {
    const GroundView view = randomDrive(random);
    const auto quantised = quantiseHomography(view);
    ASSERT_TRUE(quantised);
    EXPECT_NEAR(quantised->worst_error, worstError(quantised->words, view), 1e-6);
  }
}

TEST(HomographyQuantiser, IsFarBetterThanOneRoundingAtThePowerOfTwo) {
  test::Generator random(2);
  std::vector<double> errors;
  for (int round = 0; round < 60; ++round) {
    const GroundView view = randomDrive(random);
    const auto searched = quantiseHomography(view);
    const auto plain = quantiseAtPowerOfTwo(view);
    ASSERT_TRUE(searched && plain);
    EXPECT_LE(searched->worst_error, plain->worst_error);
    errors.push_back(searched->worst_error);
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.3);
  EXPECT_LT(errors.back(), 3.0);
}

TEST(HomographyQuantiser, NoSingleCoefficientStepImprovesTheResult) {
  test::Generator random(3);
  for (int round = 0; round < 10; ++round) {
    const GroundView view = randomDrive(random);
    const auto quantised = quantiseHomography(view);
    ASSERT_TRUE(quantised);
    for (std::size_t i = 0; i < 9; ++i) {
      for (const int step : {-1, 1}) {
        HomographyWords words = quantised->words;
        words[i] += step;
        EXPECT_GT(worstError(words, view), quantised->worst_error - 1e-6);
      }
    }
  }
}

TEST(HomographyQuantiser, CoefficientsFitTheirRegisters) {
  test::Generator random(4);
  for (int round = 0; round < 40; ++round) {
    const auto quantised = quantiseHomography(randomDrive(random));
    ASSERT_TRUE(quantised);
    for (const std::int32_t word : quantised->words) {
      EXPECT_GE(word, -131072);
      EXPECT_LE(word, 131071);
    }
  }
}

TEST(HomographyQuantiser, AViewWithoutFloorIsUnusable) {
  EXPECT_FALSE(quantiseHomography(drive(0.1, 0.0, 0.0, -0.9)));
}

TEST(HorizonQuantiser, SeparatesFloorFromSkyToWithinAPixelRow) {
  test::Generator random(5);
  for (int round = 0; round < 50; ++round) {
    const GroundView view = randomDrive(random);
    const auto words = quantiseHorizon(view);
    const GroundProjection floor(view.H_c());
    for (int u = 0; u < 640; u += 71) {
      for (int v = 0; v < 480; ++v) {
        const auto sign = words[0] * u + words[1] * v + words[2] * 16;
        const bool near = floor.inverseDepth(u, v - 2) * floor.inverseDepth(u, v + 2) <= 0.0;
        if (near) continue;
        ASSERT_EQ(sign > 0, floor.inverseDepth(u, v) > 0.0) << u << ' ' << v;
      }
    }
  }
}

TEST(CameraRegisters, RefuseByNameWhatDoesNotFit) {
  FrameParameters p;
  EXPECT_FALSE(quantiseCamera(camera(), p));
  EXPECT_EQ(p.fx, 525 * 64);
  EXPECT_EQ(p.cx, 20448);
  EXPECT_EQ(p.k1, 246);
  EXPECT_EQ(p.k2, -512);
  EXPECT_NE(quantiseCamera(camera(1024.0), p)->find("fx"), std::string::npos);
  EXPECT_NE(quantiseCamera(camera(0.001), p)->find("fx"), std::string::npos);
  EXPECT_NE(quantiseCamera(camera(525.0, {0, 4.0, 0, 0, 0}), p)->find("k2"), std::string::npos);
  EXPECT_FALSE(quantiseCamera(camera(525.0, {0, -4.0, 0, 0, 0}), p));
  const CameraModel large({641, 480, 525, 525, 320, 240}, {});
  EXPECT_NE(quantiseCamera(large, p)->find("641"), std::string::npos);
}

TEST(CameraRegisters, TurningRadiusIsTheRootOfTheDerivativeOrTheRegistersEnd) {
  FrameParameters p;
  ASSERT_FALSE(quantiseCamera(camera(525.0, {0.12, -0.25, 0, 0, 0}), p));
  const double raw = static_cast<double>(p.r2_max), q = raw / 65536.0, next = (raw + 1) / 65536.0;
  EXPECT_GE(1 + 0.36 * q - 1.25 * q * q, 0.0);
  EXPECT_LE(1 + 0.36 * next - 1.25 * next * next, 0.0);
  ASSERT_FALSE(quantiseCamera(camera(525.0, {0.1, 0.0, 0, 0, 0}), p));
  EXPECT_EQ(p.r2_max, 16777215);
}

QuantisedFocus focus(double x, double y, double w) {
  return quantiseFocus({Eigen::Vector3d(x, y, w)}, 640, 480);
}

TEST(FocusTwin, RoundsAFocusThatFits) {
  const auto f = focus(2 * 320.5, 2 * 1500.49, 2);
  EXPECT_TRUE(f.usable);
  EXPECT_FALSE(f.clamped);
  EXPECT_EQ(f.word.u, 321);  // ties away from zero
  EXPECT_EQ(f.word.v, 1500);
  EXPECT_EQ(focus(-320.5, 1000, 1).word.u, -321);
}

TEST(FocusTwin, AFocusBehindKeepsItsNegativeRow) {
  const auto f = focus(-320, 2000, -1);
  EXPECT_TRUE(f.usable);
  EXPECT_EQ(f.word.u, 320);
  EXPECT_EQ(f.word.v, -2000);
}

TEST(FocusTwin, ABeamThatRunsUpwardsIsUnusable) {
  EXPECT_FALSE(focus(320, 100, 1).usable);  // above the centre row
  EXPECT_FALSE(focus(320, -2000, 1).usable);
  EXPECT_FALSE(focus(320, 239.5, 1).usable);  // no vertical part at all
}

TEST(FocusTwin, AFarFocusIsMovedAlongTheCentresDirection) {
  const auto f = focus(320 + 40000, 80000, 1);
  EXPECT_TRUE(f.usable && f.clamped);
  EXPECT_EQ(f.word.v, 8191);
  const double slope = (320 + 40000 - 319.5) / (80000 - 239.5);
  EXPECT_EQ(f.word.u, static_cast<int>(319.5 + slope * (8191 - 239.5)));
}

TEST(FocusTwin, AParallelBeamGoesToTheLimitItMeetsFirst) {
  const auto down = focus(0, 1, 0);
  EXPECT_TRUE(down.clamped);
  EXPECT_EQ(down.word.v, 8191);
  EXPECT_EQ(down.word.u, 319);  // 319.5, truncated
  const auto left = focus(-3, 1, 0);
  EXPECT_EQ(left.word.u, -8192);
  EXPECT_EQ(left.word.v, static_cast<int>(239.5 + (8192 + 319.5) / 3));
}

TEST(FocusTwin, AFarFocusBehindIsClampedBackwards) {
  // f_w < 0 with the focus far above: lambda is negative.
  const auto f = focus(0.0, 1.0, -1e-5);
  EXPECT_TRUE(f.usable && f.clamped);
  EXPECT_EQ(f.word.v, -8192);
}

TEST(FocusTwin, AClampedFocusInRowZeroIsUnusable) {
  // Nearly horizontal beam with the focus behind and far to the left: v truncates to 0.
  const Eigen::Vector2d centre(319.5, 239.5);
  const double lambda = (-8192 - centre.x()) / -1.0;  // direction (-1, t)
  const double t = -(239.5 - 0.5) / lambda;
  // t = f_xy - f_w c with f_w = -1e-9 and the sign of lambda negative: direction is -t.
  const double w = -1e-9;
  const auto f = focus(1.0 + w * centre.x(), -t + w * centre.y(), w);
  EXPECT_FALSE(f.usable);
  EXPECT_TRUE(f.clamped);
}

TEST(SoftwarePart, PaperProfileTakesTheMeanOfThePixelPoints) {
  const GroundView view = drive(0.02, 0.0, 0.0, 0.6);
  SoftwarePart paper(FpgaParameters::paper()), ours;
  ASSERT_FALSE(paper.setCamera(view.camera));
  ASSERT_FALSE(ours.setCamera(view.camera));
  const FrameSetup a = paper.setup(view, 7), b = ours.setup(view, 7);
  ASSERT_EQ(a.status, SetupStatus::Ok);
  ASSERT_EQ(b.status, SetupStatus::Ok);
  const VanishingPoints points = vanishingPoints(view);
  const double mean_v = 0.5 * (points.f1.y() / points.f1.z() + points.f2.y() / points.f2.z());
  EXPECT_EQ(a.parameters.focus_v, std::llround(mean_v));
  EXPECT_NE(a.parameters.focus_v, b.parameters.focus_v);
  EXPECT_EQ(a.parameters.min_threshold, 0);
  EXPECT_EQ(a.parameters.single_bin_peaks, 1);
  EXPECT_EQ(b.parameters.threshold_in, 7);
  EXPECT_NO_THROW(validate(b.parameters));
}

TEST(SoftwarePart, MemoryRowsStayWithinWhatTheImageAndTheAddressAllow) {
  FpgaParameters parameters;
  parameters.memory_rows = 100;
  SoftwarePart software(parameters);
  const GroundView view = drive(0.1, 0.0, 0.0, 0.4);
  ASSERT_FALSE(software.setCamera(view.camera));
  EXPECT_EQ(software.setup(view, 255).parameters.memory_rows, 480);
}

TEST(SoftwarePart, EveryUsableDriveGivesRegistersThatTheDatapathAccepts) {
  test::Generator random(6);
  SoftwarePart software;
  ASSERT_FALSE(software.setCamera(camera()));
  for (int round = 0; round < 40; ++round) {
    const FrameSetup setup = software.setup(randomDrive(random), 20);
    ASSERT_EQ(setup.status, SetupStatus::Ok);
    EXPECT_NO_THROW(validate(setup.parameters));
  }
}

}  // namespace
}  // namespace ipm_mapping::fpga
