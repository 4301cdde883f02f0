#pragma once
// Inputs for the twin's tests: plausible registers, random and adversarial frames.

#include <cstdlib>
#include <random>
#include <vector>

#include "ipm_mapping/fpga/vectors.hpp"

namespace ipm_mapping::fpga::test {

/// Identity geometry on a small image: every pixel corresponds to itself.
inline FrameParameters identityParameters(int width, int height) {
  FrameParameters p;
  p.width = width;
  p.height = height;
  p.h11 = p.h22 = 2048;
  p.h33 = 128;
  p.horizon_c = 1;
  p.fx = p.fy = 64 * 100;
  p.cx = 32 * (width - 1);
  p.cy = 32 * (height - 1);
  p.r2_max = formats::RadiusSquared::highest();
  p.focus_u = width / 2;
  p.focus_v = 4000;
  p.min_threshold = 6;
  p.score_min = 4;
  p.min_height = 5;
  p.bearing_tolerance = 1;
  p.memory_rows = 2 * height;
  return p;
}

/// A camera like the source's at VGA, looking down a little; 10 cm of forward motion.
inline FrameParameters driveParameters(int width, int height) {
  FrameParameters p = identityParameters(width, height);
  p.h11 = 2203;
  p.h12 = -214;
  p.h13 = 2311;
  p.h21 = -17;
  p.h22 = 1771;
  p.h23 = 5409;
  p.h31 = 0;
  p.h32 = -1;
  p.h33 = 139;
  p.horizon_a = -3;
  p.horizon_b = 801;
  p.horizon_c = -4000;
  p.fx = 525 * 64 * width / 640;
  p.fy = 526 * 64 * width / 640;
  p.k1 = 410;
  p.k2 = -870;
  p.k3 = 300;
  p.r2_max = 65536 * 6 / 5;
  p.focus_v = 1400;
  p.threshold_in = 24;
  p.memory_rows = height * 819 / 480;
  return p;
}

using Generator = std::mt19937_64;

inline Integer between(Generator& random, Integer lowest, Integer highest) {
  return std::uniform_int_distribution<Integer>(lowest, highest)(random);
}

/// Blocks of grey with noise: long runs, sharp edges and every difference.
inline void paintFrame(Image<std::uint8_t>& image, int width, int height, Generator& random) {
  image.resize(width, height);
  const int block = static_cast<int>(between(random, 1, 24));
  const auto noise = between(random, 0, 40);
  std::vector<int> level(static_cast<std::size_t>((width / block + 1) * (height / block + 1)));
  for (int& value : level) value = static_cast<int>(between(random, -40, 295));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto cell = static_cast<std::size_t>(v / block * (width / block + 1) + u / block);
      const Integer grey = level[cell] + between(random, -noise, noise);
      image.at(u, v) = static_cast<std::uint8_t>(grey < 0 ? 0 : grey > 255 ? 255 : grey);
    }
  }
}

/// Every register anywhere in its wire: the adversary.
inline FrameParameters anyParameters(int width, int height, Generator& random) {
  FrameParameters p;
  p.width = width;
  p.height = height;
  FrameParameters::fields(p, [&](const char* name, Integer& value, Integer low, Integer high) {
    const std::string field = name;
    if (field != "width" && field != "height") value = between(random, low, high);
  });
  if (p.focus_v == 0) p.focus_v = 1;
  return p;
}

/// Plausible registers with some of them moved or put on an edge.
inline FrameParameters disturbedParameters(int width, int height, Generator& random) {
  FrameParameters p = driveParameters(width, height);
  FrameParameters::fields(p, [&](const char* name, Integer& value, Integer low, Integer high) {
    const std::string field = name;
    if (field == "width" || field == "height") return;
    const Integer dice = between(random, 0, 29);
    if (dice == 0) value = low;
    if (dice == 1) value = high;
    if (dice == 2) value = between(random, low, high);
    if (dice > 2 && dice < 12)
      value += between(random, -std::abs(value) / 8 - 1, std::abs(value) / 8 + 1);
    value = value < low ? low : value > high ? high : value;
  });
  if (p.focus_v == 0) p.focus_v = 1;
  return p;
}

inline OwnedInputs randomInputs(int width, int height, Generator& random) {
  OwnedInputs inputs;
  paintFrame(inputs.reference, width, height, random);
  paintFrame(inputs.current, width, height, random);
  const auto kind = between(random, 0, 9);
  inputs.parameters = kind == 0  ? anyParameters(width, height, random)
                      : kind < 4 ? driveParameters(width, height)
                                 : disturbedParameters(width, height, random);
  return inputs;
}

}  // namespace ipm_mapping::fpga::test
