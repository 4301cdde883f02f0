// Every instruction set of the machine, and the plain loops, give the same bits.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <functional>

#include "ipm_mapping/kernels/chain_sample.hpp"
#include "ipm_mapping/kernels/chain_segment.hpp"
#include "ipm_mapping/stages/undistort_warp.hpp"
#include "support/pictures.hpp"
#include "support/views.hpp"

namespace ipm_mapping::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The plain loops: Highway's name for no vector instructions at all.
constexpr std::int64_t plain = HWY_SCALAR | HWY_EMU128;

/// Runs `body` with nothing better than each target, the plain loops last; `name` is the target's.
void onEveryTarget(const std::function<void(const std::string& name)>& body) {
  hwy::SetSupportedTargetsForTest(0);
  const std::int64_t all = hwy::SupportedTargets();
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    hwy::SetSupportedTargetsForTest(all & ~(target - 1));
    body(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
}
void onPlainLoops(const std::function<void()>& body) {
  hwy::SetSupportedTargetsForTest(0);
  hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & plain);
  body();
  hwy::SetSupportedTargetsForTest(0);
}

Bytes bytes(std::mt19937& random, int width, bool valid = false) {
  Bytes row(static_cast<std::size_t>(width));
  for (auto& b : row)
    b = static_cast<std::uint8_t>(valid ? 255 * draw(random, 0, 1) : draw(random, 0, 255));
  return row;
}

/// Everything that the row kernels write, one after the other.
Bytes rowOutputs(int width) {
  std::mt19937 random(static_cast<unsigned>(width));
  const Bytes a = bytes(random, width), b = bytes(random, width), c = bytes(random, width);
  const Bytes valid = bytes(random, width, true), eroded = bytes(random, width, true);
  const auto n = static_cast<std::size_t>(width);
  std::vector<std::uint16_t> sums(n);
  Bytes scratch(n), all;
  const auto keep = [&](const std::function<void(std::uint8_t*, std::uint8_t*)>& kernel) {
    Bytes out(n + 1, 0xA5), second(n + 1, 0xA5);
    kernel(out.data(), second.data());
    EXPECT_EQ(out[n], 0xA5) << "written past the row of " << width;
    EXPECT_EQ(second[n], 0xA5);
    all.insert(all.end(), out.begin(), out.end());
    all.insert(all.end(), second.begin(), second.end());
  };
  keep([&](auto* out, auto*) {
    kernels::differenceRow(a.data(), b.data(), valid.data(), width, out);
  });
  keep([&](auto* out, auto* seen) {
    kernels::blurRow(a.data(), b.data(), c.data(), valid.data(), width, sums.data(), out, seen);
  });
  for (const int threshold : {0, 100, 127, 128, 255})
    keep([&](auto* out, auto*) {
      kernels::binarizeRow(a.data(), valid.data(), threshold, width, out);
    });
  keep([&](auto* out, auto*) {
    kernels::erodeRow(a.data(), b.data(), c.data(), width, scratch.data(), out);
  });
  keep([&](auto* out, auto*) { kernels::composeMaskRow(eroded.data(), valid.data(), width, out); });
  all.push_back(static_cast<std::uint8_t>(kernels::countNonZero(valid.data(), width)));
  return all;
}

TEST(ChainKernels, SegmentationRowsAreEqualOnEveryTarget) {
  for (int width = 1; width <= 200; ++width) {
    Bytes expected;
    onPlainLoops([&] { expected = rowOutputs(width); });
    onEveryTarget([&](const std::string& name) {
      ASSERT_EQ(rowOutputs(width), expected) << name << " width " << width;
    });
  }
}

TEST(ChainKernels, WarpIsEqualOnEveryTarget) {
  std::mt19937 random(50);
  for (const auto& [camera_name, camera] : cameras()) {
    for (const auto& [pose_name, pose] : cameraPoses()) {
      for (const auto& [motion_name, motion] : motions()) {
        GroundView view;
        view.camera = camera;
        view.T_base_camera = pose;
        view.motion = motion;
        const Picture raw = noise(camera.width(), camera.height(), random);
        const auto run = [&](Picture& current, Picture& warped, Picture& valid) {
          UndistortWarp warp(view.camera);
          warp.undistort(raw.view(), current.view(), valid.view());
          warp.warp(raw.view(), view, warped.view(), valid.view());
        };
        const Picture empty(camera.width(), camera.height());
        Picture current = empty, warped = empty, valid = empty;
        onPlainLoops([&] { run(current, warped, valid); });
        const std::string setting = camera_name + pose_name + motion_name;
        onEveryTarget([&](const std::string& name) {
          Picture c = empty, w = empty, s = empty;
          run(c, w, s);
          EXPECT_TRUE(equal(c, current)) << name << " " << setting;
          EXPECT_TRUE(equal(w, warped)) << name << " " << setting;
          EXPECT_TRUE(equal(s, valid)) << name << " " << setting;
        });
      }
    }
  }
}

TEST(ChainKernels, SamplesScatteredOverThePictureAreEqualOnEveryTarget) {
  // Far more rows and columns in a block than a wide load holds.
  std::mt19937 random(51);
  const int W = 300, H = 200;
  const Picture raw = noise(W, H, random);
  for (const int spread : {0, 3, 12, 13, 60, 120, 140}) {
    kernels::Samples samples;
    samples.resize(200, 1);
    for (int u = 0; u < 200; ++u) {
      if (draw(random, 0, 9) == 0) continue;  // outside
      const double u_raw = std::min(u + draw(random, 0.0, 1.0) * spread, W - 1.0);
      const double v_raw = std::min(30.0 + draw(random, 0.0, 1.0) * spread, H - 1.0);
      kernels::Samples::put(samples.row(0), u, u_raw, v_raw, W, H);
    }
    kernels::Samples::put(samples.row(0), 199, W - 1.0, H - 1.0, W, H);  // the last pixel
    std::vector<std::uint16_t> scratch(2 * static_cast<std::size_t>(samples.paddedWidth()));
    const auto run = [&] {
      Bytes out(200), valid(200);
      kernels::sampleRow(raw.view(), samples.row(0), 200, kernels::Validity::Set, scratch.data(),
                         out.data(), valid.data());
      out.insert(out.end(), valid.begin(), valid.end());
      return out;
    };
    Bytes expected;
    onPlainLoops([&] { expected = run(); });
    EXPECT_EQ(expected[199], raw(W - 1, H - 1));
    onEveryTarget([&](const std::string& name) { EXPECT_EQ(run(), expected) << name << spread; });
  }
}

TEST(ChainKernels, EveryTargetOfTheMachineIsTried) {
  int targets = 0;
  onEveryTarget([&](const std::string&) { ++targets; });
  EXPECT_GE(targets, 2);  // the plain loops and a vector unit
}

}  // namespace
}  // namespace ipm_mapping::test
