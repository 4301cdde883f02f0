#include <algorithm>

#include "canvases.hpp"
#include "rules.hpp"
#include "vectors.hpp"

namespace oracle {

Inputs fewLevels(Random& random) {
  Inputs in = canvas(random, random.in(3, 120), random.in(3, 90));
  const int a = random.in(0, 255), b = random.in(0, 255), c = random.in(0, 255);
  const int stripe = random.in(1, 12);
  for (size_t i = 0; i < in.current.size(); ++i) {
    const size_t u = i % static_cast<size_t>(in.params.width);
    in.current[i] = static_cast<uint8_t>(u / static_cast<size_t>(stripe) % 2 == 0 ? a : b);
    if (random.chance(2)) in.current[i] = static_cast<uint8_t>(c);
  }
  return in;
}

Inputs saturating(Random& random) {
  Inputs in = canvas(random, random.in(60, 640), random.in(40, 200));
  Params& p = in.params;
  p.fx = random.in(1, 64 * p.width / 8);
  p.fy = random.in(1, 64 * p.height / 8);
  p.cx = 64 * random.in(0, p.width);
  p.cy = 64 * random.in(0, p.height);
  if (random.chance(40)) {
    // xn meets an end of its 20 bits exactly.
    p.fx = random.pick({64, 128, 256, 512, 1024});
    p.fy = random.pick({64, 128, 256, 512, 1024});
  }
  p.k1 = random.pick({0, 0, random.in(-8192, 8191)});
  p.k2 = random.pick({0, random.in(-8192, 8191)});
  p.k3 = random.pick({0, random.in(-8192, 8191)});
  p.r2_max = random.pick({16777215, 16777215, 4194304, random.in(0, 9000000)});
  p.paper_order = random.in(0, 1);
  p.h12 = random.in(-300, 300);
  p.h13 = random.in(-9000, 9000);
  p.h31 = random.in(-5, 5);
  p.h32 = random.in(-5, 5);
  fillNoise(in, random);
  return in;
}

namespace {

/// x or y passes an end of signed 12.6, one LSB a pixel.
void crossViewLimit(Params& p, Random& random) {
  const int sign = random.pick({-1, 1});
  const int start = (131072 - random.in(0, p.width)) * sign;
  setHomography(p, {16 * sign, 0, std::clamp(start, -131072, 131071), 0, 16, random.in(-9000, 9000),
                    0, 0, 64});
  if (random.chance(50)) {
    std::swap(p.h11, p.h22);
    std::swap(p.h13, p.h23);
  }
}

/// Distortion first: its outcome passes the ends of signed 12.6 and is scaled back into the image.
void crossBentLimit(Params& p, Random& random) {
  const int shrink = random.in(40, 160);
  setHomography(p, {shrink, 0, 64 * p.width, 0, shrink, 64 * p.height, 0, 0, 128});
  p.fx = p.fy = 64 * p.width / random.in(2, 5);
  p.k1 = 2048 * random.in(1, 4) - random.in(0, 2000);
  p.r2_max = 16777215;
  p.paper_order = 1;
}

/// Exchanges the roles of x and y.
void transpose(Params& p) {
  std::swap(p.width, p.height);
  std::swap(p.fx, p.fy);
  std::swap(p.cx, p.cy);
  std::swap(p.h11, p.h22);
  std::swap(p.h13, p.h23);
  p.memory_rows = std::clamp(p.memory_rows, p.height, 524288 / p.width);
}

/// The same to the LSB: xn is saturated, so that cx alone places x, and y is taken to the middle
/// row. Nothing else may hide the pixel.
void meetBentLimit(Params& p, Random& random) {
  const int sign = random.pick({-1, 1}), shrink = random.in(4, p.width / 2 - 4);
  setHomography(p, {shrink, 0, 64 * p.width, 0, 0, 64 * p.height, 0, 0, 128});
  p.fx = 64;
  p.fy = 64 * random.in(60, 300);
  p.cx = 64 * 40;
  p.k1 = sign > 0 ? 8120 : 8191;
  p.k2 = sign > 0 ? 0 : 1;
  p.r2_max = 16777215;
  p.paper_order = 1;
  p.use_horizon = p.undistort_current = 0;
  Wires unused;
  const Point edge{true, sign > 0 ? 64 * (p.width - 1) : 0, p.cy};
  const Point bent = distort(p, edge, unused.overflow[Xn], unused.overflow[Yn], unused);
  const int target = sign > 0 ? 131072 - random.in(0, 3) : -131073 + random.in(0, 3);
  p.cx = std::clamp(p.cx + target - static_cast<int>(bent.x), 0, 65535);
  if (random.chance(50)) transpose(p);
}

/// yn meets an end of its 20 bits exactly on one row, and xn does not leave them.
void meetNormalizedLimit(Params& p, Random& random) {
  p.fx = random.in(20000, 65535);
  p.fy = 64 << random.in(0, 2);
  p.cy = 64 * random.in(10, p.height - 10);
  p.k1 = random.in(-1, 1);
  p.r2_max = 16777215;
  if (random.chance(30)) transpose(p);
}

/// D passes 0 at a row.
void crossDepthZero(Params& p, Random& random) {
  const int slope = random.pick({-16, 16}) * random.in(1, 200);
  const int row = random.in(1, p.height - 1);
  setHomography(p, {2048, 0, 0, 0, 2048, 0, 0, slope, -slope / 16 * row});
}

/// A radius that a pixel of the current view meets exactly.
int radiusOfAPixel(const Params& p, Random& random) {
  const int64_t xn = (int64_t{64} * random.in(0, p.width - 1) - p.cx) * 65536 / p.fx;
  const int64_t yn = (int64_t{64} * random.in(0, p.height - 1) - p.cy) * 65536 / p.fy;
  return static_cast<int>(std::min<int64_t>(16777215, (xn * xn + yn * yn) >> 16));
}

}  // namespace

/// Formats' ends met exactly: 12.6, horizon, D = 0, turning radius.
Inputs limits(Random& random) {
  Inputs in = canvas(random, random.in(64, 300), random.in(20, 100));
  Params& p = in.params;
  const int slope = random.pick({-16, 16}) * random.in(1, 200);
  p.horizon_a = 0;
  p.horizon_b = slope;
  p.horizon_c = -slope / 16 * random.in(0, p.height - 1);
  p.fx = random.pick({1, 2, 128, 256, 512, 1024, 32768, 65535});
  p.fy = random.pick({1, 2, 128, 256, 512, 1024, 32768, 65535});
  p.cx = 32 * p.width;
  p.cy = 32 * p.height;
  p.k1 = random.pick({0, 0, -1, 1, random.in(-8192, 8191)});
  p.paper_order = random.in(0, 1);
  p.use_horizon = random.in(0, 1);
  if (random.chance(50)) p.r2_max = radiusOfAPixel(p, random);
  const int which = random.in(0, 5);
  if (which == 0) crossViewLimit(p, random);
  if (which == 1) crossBentLimit(p, random);
  if (which == 2) meetBentLimit(p, random);
  if (which == 3) crossDepthZero(p, random);
  if (which == 4) meetNormalizedLimit(p, random);
  fillNoise(in, random);
  return in;
}

/// Every entry anywhere (or at an end) of its range; a part near the identity.
Inputs anything(Random& random, bool extremes) {
  Inputs in;
  Params& p = in.params;
  for (const Entry& e : entries()) {
    p.*e.value = extremes ? random.pick({e.lowest, e.lowest + 1, 0, 1, e.highest - 1, e.highest})
                          : random.in(e.lowest, e.highest);
    p.*e.value = std::clamp(p.*e.value, e.lowest, e.highest);
  }
  setSize(p, random.in(1, 200), random.in(1, 120));
  if (random.chance(60)) {
    setHomography(p, {random.in(1800, 2300), random.in(-100, 100), random.in(-3000, 3000),
                      random.in(-100, 100), random.in(1800, 2300), random.in(-3000, 3000),
                      random.in(-1, 1), random.in(-1, 1), random.in(100, 160)});
  }
  p.memory_rows = random.pick({p.height, 524288 / p.width, p.height + random.in(0, 60)});
  p.memory_rows = std::min(p.memory_rows, 524288 / p.width);
  if (p.focus_v == 0) p.focus_v = 1;
  fillNoise(in, random);
  return in;
}

Inputs tiny(Random& random) {
  if (random.chance(50)) return drawnTriangles(random, random.in(1, 14), random.in(1, 14));
  Inputs in = anything(random, false);
  setSize(in.params, random.in(1, 14), random.in(1, 14));
  in.params.memory_rows = random.in(in.params.height, 2 * in.params.height);
  fillNoise(in, random);
  return in;
}

Inputs memoryOverlap(Random& random) {
  Inputs in = canvas(random, random.in(20, 640), random.in(60, 480));
  Params& p = in.params;
  p.memory_rows = std::min(524288 / p.width, p.height + random.in(0, 70));
  p.h23 = random.in(-14000, 14000);
  p.h21 = random.in(-200, 200);
  fillNoise(in, random);
  return in;
}

}  // namespace oracle
