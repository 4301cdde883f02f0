#pragma once
// Random and adversarial inputs for the datapath. The same seed and kind always give the same
// frame, on every machine.

#include <initializer_list>
#include <random>

#include "oracle.hpp"
#include "software.hpp"

namespace oracle {

enum Kind {
  Plausible,      ///< rendered robot scene with the quantised homography of its motion
  LevelCamera,    ///< the same, pitch 0: the focus is clamped
  HorizonInView,  ///< the same, the horizon crosses both images
  TurningRadius,  ///< the same, k2 < 0 so that the polynomial turns over inside the image
  PaperOrder,     ///< the same, distortion first
  Saturating,     ///< focal lengths so short that xn and yn saturate
  Tiny,           ///< images from 1x1 to 14x14
  ExtremeFocus,   ///< drawn shapes, focus word at its limits, near 0, near the starting columns
  FocusInside,    ///< drawn, lines end at a focus inside the image
  Limits,         ///< one LSB a pixel across the ends of the coordinates' formats
  Triangles,      ///< drawn triangles along the lines of the beam
  Comb,           ///< drawn, more than 32 peaks
  Plateaus,       ///< drawn, runs of equal bins
  TallBands,      ///< drawn, Bear over 255 and A2 over 16383
  Ties,           ///< drawn, contacts of one obstacle in the same row
  Flat,           ///< constant images
  Noise,          ///< nothing but noise
  MemoryOverlap,  ///< reads close behind the writes
  FewLevels,      ///< differences of two or three grey levels
  Uniform,        ///< every parameter anywhere in its range
  Extremes,       ///< every parameter at or beside an end of its range
  KindCount
};
const char* kindName(Kind kind);

Inputs randomInputs(uint64_t seed, Kind kind);

/// A camera and a motion as a robot has them, for the software part.
Camera randomCamera(uint64_t seed);
Motion randomMotion(uint64_t seed);

/// Draws that do not depend on the standard library.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed * 0x9e3779b97f4a7c15ULL + 1) { engine_.discard(8); }
  int in(int lowest, int highest) {
    const auto count = static_cast<uint64_t>(int64_t{highest} - lowest + 1);
    return static_cast<int>(lowest + static_cast<int64_t>(engine_() % count));
  }
  Real real(Real lowest, Real highest) {
    return lowest + (highest - lowest) * static_cast<Real>(engine_() >> 11) / 9007199254740992.0L;
  }
  bool chance(int percent) { return in(0, 99) < percent; }
  int pick(std::initializer_list<int> values) {
    return values.begin()[in(0, static_cast<int>(values.size()) - 1)];
  }

 private:
  std::mt19937_64 engine_;
};

Camera drawCamera(Random& random, int width, int height);
Motion drawMotion(Random& random);

// Images (pictures.cpp). All write both images of `inputs` in the size of its parameters.
void fillFlat(Inputs& inputs, int reference, int current);
void fillNoise(Inputs& inputs, Random& random);
void renderScene(Inputs& inputs, const Camera& camera, const Motion& motion, Random& random);

/// A stroke along one line of the beam, its width changing from top to bottom.
struct Stroke {
  int line, first, last, top_width, bottom_width, jitter;
};
void draw(Inputs& inputs, const Stroke& stroke, int grey, Random& random);

}  // namespace oracle
