#include "canvases.hpp"

#include <algorithm>

namespace oracle {

/// Everything that does not come from geometry.
void drawOptions(Params& p, Random& random) {
  p.use_horizon = random.chance(80) ? 1 : 0;
  p.threshold_in = random.pick({0, 1, 6, 12, 20, 60, 255});
  p.min_threshold = random.pick({0, 6, 6, 20, 255});
  if (random.chance(70)) p.threshold_in = p.min_threshold = random.in(0, 12);
  p.score_min = random.chance(80) ? random.in(0, 8) : random.in(0, 511);
  p.min_height = random.chance(80) ? random.in(0, 12) : random.in(0, 511);
  p.valley_threshold = random.chance(60) ? random.in(1, 4) : random.in(1, 31);
  p.bearing_tolerance = random.chance(70) ? random.in(0, 4) : random.in(0, 79);
  p.undistort_current = random.in(0, 1);
  p.method = random.in(0, 1);
  p.single_bin_peaks = random.in(0, 1);
  p.free_space_rule = random.in(0, 1);
  const int most_rows = 524288 / p.width;
  p.memory_rows = random.chance(50) ? std::clamp(819, p.height, most_rows)
                                    : random.in(p.height, std::min(most_rows, 3 * p.height));
}

void setHomography(Params& p, const Coefficients& h) {
  int Params::*const names[] = {&Params::h11, &Params::h12, &Params::h13,
                                &Params::h21, &Params::h22, &Params::h23,
                                &Params::h31, &Params::h32, &Params::h33};
  for (size_t i = 0; i < 9; ++i) p.*names[i] = h[i];
}

void setSize(Params& p, int width, int height) {
  p.width = width;
  p.height = height;
}

/// Parameters under which the current image appears unmoved in front of the reference.
Inputs canvas(Random& random, int width, int height) {
  Inputs in;
  Params& p = in.params;
  setSize(p, width, height);
  drawOptions(p, random);
  const int scale = random.in(1, 60);
  setHomography(p, {2048 * scale, 0, 0, 0, 2048 * scale, 0, 0, 0, 128 * scale});
  p.horizon_c = random.in(1, 131071);
  p.fx = 64 * random.in(200, 900);
  p.fy = 64 * random.in(200, 900);
  p.focus_u = random.in(0, 639);
  p.focus_v = random.pick({-1, 1, 1, 1}) * random.in(600, 8191);
  p.threshold_in = random.in(0, 14);
  p.min_threshold = random.in(0, 14);
  fillFlat(in, 0, 0);
  return in;
}

namespace {

void sprinkle(Inputs& in, Random& random) {
  const int count = random.pick({0, 0, 5, 60});
  for (int n = 0; n < count; ++n) {
    const size_t at = static_cast<size_t>(random.in(0, static_cast<int>(in.current.size()) - 1));
    in.current[at] = static_cast<uint8_t>(random.in(0, 255));
  }
}

}  // namespace

Inputs drawnTriangles(Random& random, int width, int height) {
  Inputs in = canvas(random, width, height);
  for (int n = random.in(1, 60); n > 0; --n) {
    const int first = random.in(-10, height - 1), last = first + random.in(1, height);
    const Stroke stroke{random.in(0, 79),         first, last, random.in(0, 14), random.in(0, 14),
                        random.pick({0, 0, 1, 2})};
    draw(in, stroke, random.pick({255, 255, 40}), random);
  }
  sprinkle(in, random);
  return in;
}

Inputs drawnComb(Random& random) {
  Inputs in = canvas(random, 640, random.in(40, 200));
  const int period = random.pick({2, 2, 2, 3, 4}), phase = random.in(0, 1);
  for (int line = phase; line < 80; line += period) {
    const int last = random.in(10, in.params.height - 2);
    draw(in, Stroke{line, random.in(0, 4), last, random.in(3, 8), random.in(3, 8), 0}, 255, random);
  }
  return in;
}

Inputs drawnPlateaus(Random& random) {
  Inputs in = canvas(random, 640, random.in(60, 200));
  const int half = in.params.height / 2;
  in.params.focus_u = random.in(280, 360);
  in.params.focus_v = random.pick({-8192, 8191});
  for (int line = 0; line < 80;) {
    const int last = random.pick({0, half / 2, half, half + 20});
    for (int run = random.in(1, 4); run > 0 && line < 80; --run, ++line) {
      if (last > 0) draw(in, Stroke{line, 1, last, 7, 7, 0}, 255, random);
    }
  }
  return in;
}

Inputs drawnTallBands(Random& random) {
  Inputs in = canvas(random, 640, random.in(270, 480));
  in.params.focus_v = random.in(3000, 8191);
  const int spread = random.pick({0, 3, 30});
  const bool both_ends = random.chance(70);
  for (int line = 0; line < 80; ++line) {
    if (both_ends && line > spread && line < 79 - spread) continue;
    if (!both_ends && random.chance(60)) continue;
    draw(in, Stroke{line, 0, random.in(200, 480), 8, 8, 0}, 255, random);
  }
  return in;
}

Inputs drawnTies(Random& random) {
  Inputs in = canvas(random, 640, random.in(60, 200));
  in.params.score_min = random.in(0, 5);
  in.params.min_height = random.in(0, 8);
  in.params.focus_v = random.in(2000, 8191);
  const int bottom = random.in(30, in.params.height - 4);
  for (int line = random.in(0, 6); line < 74; line += random.in(4, 9)) {
    if (random.chance(50))
      draw(in, Stroke{line + 1, 0, bottom + random.in(0, 3), 3, 3, 0}, 255, random);
    const int top = random.in(5, 12);
    draw(in, Stroke{line, top, bottom, 7, 6, 0}, 255, random);
    draw(in, Stroke{line + 2, top + random.in(0, 1), bottom, 7, 6, 0}, 255, random);
    if (random.chance(30)) draw(in, Stroke{line + 1, top, bottom, 7, 6, 0}, 255, random);
  }
  return in;
}

Inputs extremeFocus(Random& random) {
  Inputs in = drawnTriangles(random, random.pick({640, 640, 333}), random.in(20, 240));
  Params& p = in.params;
  p.focus_u = random.pick({-8192, 8191, 0, 4, 12, 316, 636, -1, random.in(-8192, 8191)});
  p.focus_v = random.pick({-8192, 8191, 1, -1, 2, p.height - 1, p.height, random.in(1, 480)});
  if (random.chance(40)) fillNoise(in, random);
  return in;
}

/// The focus inside the image: lines end at it while they still see obstacle pixels.
Inputs focusInside(Random& random) {
  Inputs in = canvas(random, random.pick({640, 640, 200}), random.in(40, 200));
  Params& p = in.params;
  p.focus_u = random.in(0, p.width - 1);
  p.focus_v = random.in(8, p.height - 1);
  p.score_min = random.in(0, 6);
  p.min_height = random.in(0, 8);
  for (int n = random.in(1, 50); n > 0; --n) {
    const int first = random.in(-5, p.focus_v - 1);
    const Stroke stroke{random.in(0, 79),
                        first,
                        first + random.in(5, p.height),
                        random.in(3, 14),
                        random.in(3, 14),
                        random.pick({0, 0, 1})};
    draw(in, stroke, 255, random);
  }
  return in;
}

}  // namespace oracle
