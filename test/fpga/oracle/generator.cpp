#include "canvases.hpp"

#include <algorithm>
#include <cmath>

namespace oracle {
namespace {

int fixed(Real value, Real one, int lowest, int highest) {
  return std::clamp(static_cast<int>(std::round(value * one)), lowest, highest);
}

void setLens(Params& p, const Camera& camera) {
  p.fx = fixed(camera.fx, 64, 1, 65535);
  p.fy = fixed(camera.fy, 64, 1, 65535);
  p.cx = fixed(camera.cx, 64, 0, 65535);
  p.cy = fixed(camera.cy, 64, 0, 65535);
  p.k1 = fixed(camera.k1, 2048, -8192, 8191);
  p.k2 = fixed(camera.k2, 2048, -8192, 8191);
  p.k3 = fixed(camera.k3, 2048, -8192, 8191);
  p.r2_max = r2Max(camera);
}

void setGeometry(Params& p, const Camera& camera, const Motion& motion, Random& random) {
  const TwoViews views = twoViews(camera, motion);
  Coefficients h{};
  const Real scale = largestPowerOfTwo(views.current_to_reference);
  quantise(views.current_to_reference, scale * random.real(0.6L, 1), h);
  if (random.chance(10)) {
    const Fit fit = fitHomography(camera, views);
    if (fit.usable) h = fit.h;
  }
  setHomography(p, h);
  const std::array<int, 3> horizon = horizonCoefficients(views);
  p.horizon_a = horizon[0];
  p.horizon_b = horizon[1];
  p.horizon_c = horizon[2];
  const Focus focus = focusWord(midFoot(views), p.width, p.height);
  p.focus_u = focus.usable ? focus.u : 0;
  p.focus_v = focus.usable ? focus.v : 8191;
}

/// A rendered scene; `tune` changes camera and motion before anything is derived from them.
template <class Tune>
Inputs rendered(Random& random, Tune tune) {
  Inputs in;
  const bool vga = random.chance(15);
  setSize(in.params, vga ? 640 : random.in(40, 320), vga ? 480 : random.in(30, 240));
  Camera camera = drawCamera(random, in.params.width, in.params.height);
  Motion motion = drawMotion(random);
  tune(camera, motion);
  drawOptions(in.params, random);
  setLens(in.params, camera);
  setGeometry(in.params, camera, motion, random);
  renderScene(in, camera, motion, random);
  return in;
}

}  // namespace

Camera drawCamera(Random& random, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = width * random.real(0.6L, 1.3L);
  camera.fy = camera.fx * random.real(0.95L, 1.05L);
  camera.cx = width * random.real(0.45L, 0.55L);
  camera.cy = height * random.real(0.45L, 0.55L);
  camera.k1 = random.real(-0.3L, 0.2L);
  camera.k2 = random.real(-0.05L, 0.1L);
  camera.k3 = random.chance(50) ? 0 : random.real(-0.05L, 0.05L);
  return camera;
}

Motion drawMotion(Random& random) {
  Motion motion;
  motion.height = random.real(0.15L, 0.8L);
  motion.pitch = random.real(0.1L, 0.9L);
  motion.lead = random.real(-0.1L, 0.3L);
  motion.x = random.real(-0.05L, 0.3L);
  motion.y = random.real(-0.02L, 0.02L);
  motion.angle = random.real(-0.08L, 0.08L);
  return motion;
}

Camera randomCamera(uint64_t seed) {
  Random random(seed);
  return drawCamera(random, random.pick({640, 320}), random.pick({480, 240}));
}

Motion randomMotion(uint64_t seed) {
  Random random(seed + 77);
  return drawMotion(random);
}

const char* kindName(Kind kind) {
  static const char* const names[KindCount] = {
      "plausible",  "level camera", "horizon in view", "turning radius", "paper order",
      "saturating", "tiny",         "extreme focus",   "focus inside",   "limits",
      "triangles",  "comb",         "plateaus",        "tall bands",     "ties",
      "flat",       "noise",        "memory overlap",  "few levels",     "uniform",
      "extremes"};
  return names[kind];
}

namespace {

Inputs renderedInputs(Random& random, Kind kind) {
  const auto tune = [&](Camera& camera, Motion& motion) {
    if (kind == LevelCamera) motion.pitch = random.chance(50) ? 0 : random.real(-0.05L, 0.02L);
    if (kind == HorizonInView) motion.pitch = random.real(0.02L, 0.25L);
    if (kind != TurningRadius) return;
    camera.k1 = random.real(-0.3L, 0.1L);
    camera.k2 = random.real(-2, -0.3L);
    camera.k3 = random.real(-1, 0.5L);
  };
  Inputs in = rendered(random, tune);
  if (kind == PaperOrder) in.params.paper_order = 1;
  if (kind == HorizonInView) in.params.use_horizon = random.in(0, 1);
  return in;
}

}  // namespace

Inputs randomInputs(uint64_t seed, Kind kind) {
  Random random(seed * 100 + static_cast<uint64_t>(kind));
  if (kind <= PaperOrder) return renderedInputs(random, kind);
  if (kind == Saturating) return saturating(random);
  if (kind == Tiny) return tiny(random);
  if (kind == ExtremeFocus) return extremeFocus(random);
  if (kind == FocusInside) return focusInside(random);
  if (kind == Limits) return limits(random);
  if (kind == Triangles) return drawnTriangles(random, 640, random.in(30, 300));
  if (kind == Comb) return drawnComb(random);
  if (kind == Plateaus) return drawnPlateaus(random);
  if (kind == TallBands) return drawnTallBands(random);
  if (kind == Ties) return drawnTies(random);
  if (kind == MemoryOverlap) return memoryOverlap(random);
  if (kind == FewLevels) return fewLevels(random);
  if (kind == Uniform || kind == Extremes) return anything(random, kind == Extremes);
  Inputs in = canvas(random, random.in(1, 640), random.in(1, 300));
  if (kind == Flat) fillFlat(in, random.in(0, 255), random.in(0, 255));
  if (kind == Noise) fillNoise(in, random);
  return in;
}

}  // namespace oracle
