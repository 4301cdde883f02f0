#pragma once
// The software part of the contract in long double: quantised homography (rule 3), turning radius
// (rule 4), focus word (rule 10). Demanded of the twin is only the error that it achieves.

#include <array>
#include <vector>

#include "oracle.hpp"

namespace oracle {

using Real = long double;
using Vector = std::array<Real, 3>;
using Matrix = std::array<Vector, 3>;
using Coefficients = std::array<int, 9>;

Vector product(const Matrix& a, const Vector& x);
Matrix product(const Matrix& a, const Matrix& b);
Matrix inverse(const Matrix& a);

/// Pinhole with radial distortion; pixels, distortion of the unit plane.
struct Camera {
  int width = 640, height = 480;
  Real fx = 500, fy = 500, cx = 320, cy = 240, k1 = 0, k2 = 0, k3 = 0;
};

/// Camera height and pitch (metres, radians, down is positive), its lead over the base's origin,
/// and the pose of the current base in the reference base.
struct Motion {
  Real height = 0.4L, pitch = 0.35L, lead = 0.1L;
  Real x = 0.1L, y = 0, angle = 0;
};

/// Floor of the reference base to reference and to current pixels, and current to reference.
struct TwoViews {
  Matrix floor_to_reference, floor_to_current, current_to_reference;
  Vector f1, f2;  ///< images of the current and the reference camera's foot, scales kept
};
TwoViews twoViews(const Camera& camera, const Motion& motion);

/// Smallest positive root of 1 + 3 k1 q + 5 k2 q^2 + 7 k3 q^3; infinity if none.
Real turningRadiusSquared(const Camera& camera);
int r2Max(const Camera& camera);

struct GridPoint {
  int u, v;
  Real x, y;  ///< G p
};
/// Rule 3: the points over which the error of a quantised homography is taken.
std::vector<GridPoint> gridPoints(const Camera& camera, const TwoViews& views);

/// Largest distance over the points; infinity where D <= 0 at one of them.
Real quantisationError(const Coefficients& h, const std::vector<GridPoint>& points);

/// Coefficients of G at a scale, rounded; false if one leaves 18 bits.
bool quantise(const Matrix& g, Real scale, Coefficients& h);
Real largestPowerOfTwo(const Matrix& g);

struct Fit {
  bool usable = false;
  Coefficients h{};
  Real error = 0;
};
/// Rule 3: scale search, ranking and polish.
Fit fitHomography(const Camera& camera, const TwoViews& views);

/// Third row of the inverse, scaled to the largest power of two that fits.
std::array<int, 3> horizonCoefficients(const TwoViews& views);

struct Focus {
  bool usable = false, clamped = false;
  int u = 0, v = 0;
  Real exact_u = 0, exact_v = 0;  ///< before rounding or truncation
};
/// Rule 10: f1 + f2; `paper`: eq. 6.9 while both w > 0.
Vector midFoot(const TwoViews& views);
Vector meanPixel(const TwoViews& views);
/// Rule 10, the word.
Focus focusWord(const Vector& f, int width, int height);

}  // namespace oracle
