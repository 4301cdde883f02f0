#include <gtest/gtest.h>

#include <cmath>

#include "ipm_mapping_sim/scene_yaml.hpp"
#include "ipm_mapping_sim/simulation.hpp"

namespace ipm_mapping::sim {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kFocal = 130.0;

/// A noiseless camera before a white board that stands across the view and ends at y = 0.
Scene board(const std::string& sensor) {
  return parseScene(
      "{name: test, ambient: 1.0, ceiling: 0.0,"
      " camera: {width: 160, height: 120, fx: 130, fy: 130, cx: 79.5, cy: 59.5, x: 0, y: 0,"
      "          z: 0.5, pitch: 0},"
      " sensor: {full_well: 1.0e9, read_noise: 0, blur: 0, " +
      sensor +
      "},"
      " floor: {albedo: 0, grain: none, blotch_contrast: 0},"
      " obstacles: [{kind: box, name: b, x: 2.05, y: 1.0, lx: 0.1, ly: 2.0, h: 2.0,"
      "              material: {albedo: 0.8, grain: none}}]}");
}

std::vector<std::uint8_t> capture(const Scene& scene, double v, double w, double time = 0.0) {
  SimulatedCamera camera(scene);
  const Moving robot{[=](double t) {
                       return SE2{v * t, 0.0, w * t};
                     },
                     [=](double) {
                       return Command{v, w};
                     }};
  std::vector<std::uint8_t> grey;
  camera.capture(0, time, robot, grey);
  return grey;
}

/// Column where the board (left) ends in a row, to the nearest pixel.
int boardEnd(const std::vector<std::uint8_t>& grey, int row) {
  int u = 0;
  while (u < kWidth && grey[static_cast<std::size_t>(row * kWidth + u)] > 100) ++u;
  return u;
}

TEST(Camera, RollingShutterShearsWhatTurnsByTheTurnOfTheReadout) {
  const double rate = 2.0, readout = 0.04;
  const auto still = capture(board(""), 0.0, rate);
  EXPECT_EQ(boardEnd(still, 10), boardEnd(still, 80));
  const auto sheared = capture(board("readout_time: 0.04"), 0.0, rate);
  const double turn = rate * readout * (80.0 - 10.0) / (kHeight - 1);
  // A robot that turns left sees the board move to the right.
  EXPECT_NEAR(boardEnd(sheared, 80) - boardEnd(sheared, 10), kFocal * turn, 1.01);
}

TEST(Camera, MotionBlurIsAsWideAsTheTurnOfTheExposure) {
  const double rate = 3.0, exposure = 0.05;
  const auto partly = [](const std::vector<std::uint8_t>& grey) {  // neither board nor nothing
    const int board = grey[40 * kWidth];
    int count = 0;
    for (int u = 0; u < kWidth; ++u) {
      const std::uint8_t g = grey[static_cast<std::size_t>(40 * kWidth + u)];
      count += static_cast<int>(g > 40 && g < board - 12);
    }
    return count;
  };
  EXPECT_LE(partly(capture(board(""), 0.0, rate)), 1);
  const auto blurred = capture(board("exposure_time: 0.05, blur_samples: 32"), 0.0, rate);
  // Of a ramp from dark to bright the two limits leave 3 % to 87 % of the light.
  EXPECT_NEAR(partly(blurred), 0.84 * kFocal * rate * exposure, 2.0);
  EXPECT_LE(partly(capture(board("exposure_time: 0.05, blur_samples: 32"), 0.0, 0.0)), 1);
}

TEST(Camera, ShakeTurnsTheViewUpAndDownAndOnlyWhileItDrives) {
  const Scene scene = board("shake: 0.02, shake_rate: 5");
  const auto base = [&](double v, double time) {  // row where the board meets the floor
    const auto grey = capture(scene, v, 0.0, time);
    int row = 60;
    while (grey[static_cast<std::size_t>(row * kWidth + 20)] > 100) ++row;
    return row;
  };
  EXPECT_EQ(base(0.0, 0.05), base(0.0, 0.15));
  EXPECT_NE(base(0.001, 0.05), 0);
  EXPECT_GT(std::abs(base(0.3, 0.05) - base(0.3, 0.15)), 2);
}

TEST(Sensor, ExposureDriftsWithItsPeriodAndCornersAreDarker) {
  SensorSpec spec;
  spec.full_well = 1e9;
  spec.read_noise = spec.blur = 0.0;
  spec.drift = 0.2;
  spec.drift_period = 4.0;
  spec.vignetting = 0.5;
  Sensor sensor(spec, kWidth, kHeight, 1);
  EXPECT_NEAR(sensor.gain(0, 1.0), 1.2, 1e-9);
  EXPECT_NEAR(sensor.gain(7, 3.0), 0.8, 1e-9);
  std::vector<float> light(static_cast<std::size_t>(kWidth * kHeight), 0.4F);
  std::vector<std::uint8_t> grey;
  sensor.expose(0, 0.0, light, grey);
  EXPECT_NEAR(grey[static_cast<std::size_t>(kHeight / 2 * kWidth + kWidth / 2)], sensor.tone(0.4F),
              1);
  EXPECT_NEAR(grey[0], sensor.tone(0.2F), 1);
}

TEST(Sensor, NoiseOfThePhotonsGrowsWithTheRootOfTheLight) {
  SensorSpec spec;
  spec.full_well = 2000.0;
  spec.read_noise = spec.blur = 0.0;
  Sensor sensor(spec, 400, 400, 1);
  for (const float level : {0.1F, 0.4F}) {
    std::vector<float> light(160000, level);
    std::vector<std::uint8_t> grey;
    sensor.expose(0, 0.0, light, grey);
    double sum = 0.0, square = 0.0;
    for (const std::uint8_t g : grey) {
      sum += g;
      square += static_cast<double>(g) * g;
    }
    const double mean = sum / 160000.0, deviation = std::sqrt(square / 160000.0 - mean * mean);
    const float sigma = std::sqrt(level / 2000.0F);
    const double wanted = 0.5 * (sensor.tone(level + sigma) - sensor.tone(level - sigma));
    EXPECT_NEAR(deviation, wanted, 0.15 * wanted + 0.3) << level;
  }
}

}  // namespace
}  // namespace ipm_mapping::sim
