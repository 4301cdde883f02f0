#include "ipm_mapping/detectors/fpga_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace ipm_mapping {
namespace {

/// Unrelated noisy pictures with blobs along a straight drive.
Image<std::uint8_t> picture(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> grey(100, 110), u0(0, 280), v0(80, 200);
  Image<std::uint8_t> image(320, 240);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u) image.at(u, v) = static_cast<std::uint8_t>(grey(random));
  for (int blob = 0; blob < 5; ++blob) {
    const int left = u0(random), top = v0(random);
    for (int v = top; v < std::min(240, top + 30); ++v)
      for (int u = left; u < left + 30; ++u) image.at(u, v) = 250;
  }
  return image;
}

TEST(FpgaStatistics, SumsCountersAndKeepsTheSlowestFrame) {
  const Parameters parameters = Parameters::profile("paper");
  FpgaDetector detector(parameters);
  detector.setCamera(CameraModel({320, 240, 260, 260, 159.5, 119.5}, {}),
                     cameraPose(0.05, 0.0, 0.45, 0.42));
  FpgaStatistics statistics(parameters.fpga_clock);
  Obstacles obstacles;
  std::uint64_t frames = 0, points = 0;
  fpga::OverflowCounters::Counts overflow{};
  fpga::Cycles slowest = 0, fastest = 1 << 30;
  double worst = 0.0, to_map = 0.0;
  for (unsigned i = 0; i < 10; ++i) {
    const auto image = picture(i);
    const Frame frame{i, 0.1 * i, std::as_const(image).view(), {0.06 * i, 0.0, 0.0}};
    if (detector.process(frame, obstacles) != FrameStatus::Used) continue;
    statistics.add(detector);
    const fpga::Results& r = detector.results();
    const auto timing = fpga::frameTiming(parameters.fpga_clock, 320, 240,
                                          fpga::activityOf(r, parameters.fpga.min_height));
    ++frames;
    points += static_cast<std::uint64_t>(r.selected.size);
    for (std::size_t w = 0; w < overflow.size(); ++w) overflow[w] += r.overflow.counts()[w];
    slowest = std::max(slowest, timing.after_last_pixel);
    fastest = std::min(fastest, timing.after_last_pixel);
    to_map = std::max(to_map, timing.to_map);
    worst = std::max(worst, detector.frameSetup().homography_error);
  }
  ASSERT_GE(frames, 5U);
  ASSERT_GT(points, 0U);
  ASSERT_GT(slowest, fastest);
  const auto summary = statistics.summary();
  EXPECT_EQ(summary.frames, frames);
  EXPECT_EQ(summary.points, points);
  EXPECT_EQ(summary.overflow, overflow);
  EXPECT_EQ(summary.after_last_pixel, slowest);
  EXPECT_EQ(summary.slowest_to_map, to_map);
  EXPECT_EQ(summary.worst_homography_error, worst);
  EXPECT_LE(summary.median_homography_error, worst);
  EXPECT_EQ(summary.frame, 320 * 240);
  EXPECT_GT(summary.slowest_map_rate_in_series, 0.0);
  EXPECT_LE(summary.slowest_map_rate_in_series, summary.slowest_map_rate_pipelined);
}

TEST(FpgaStatistics, AreEmptyBeforeTheFirstFrame) {
  const auto summary = FpgaStatistics(FpgaClockParameters{}).summary();
  EXPECT_EQ(summary.frames, 0U);
  EXPECT_EQ(summary.worst_homography_error, 0.0);
}

}  // namespace
}  // namespace ipm_mapping
