#include "software.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace oracle {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

bool fitsSigned(Real value, int bits) {
  const Real limit = std::ldexp(1.0L, bits - 1);
  return value >= -limit && value <= limit - 1;
}

/// Rule 1: nearest, ties away from 0.
Real nearest(Real value) { return std::round(value); }

}  // namespace

Vector product(const Matrix& a, const Vector& x) {
  Vector out{};
  for (size_t i = 0; i < 3; ++i) out[i] = a[i][0] * x[0] + a[i][1] * x[1] + a[i][2] * x[2];
  return out;
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    }
  }
  return out;
}

Matrix inverse(const Matrix& a) {
  Matrix out{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const size_t r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      out[i][j] = a[r][c] * a[s][d] - a[r][d] * a[s][c];
    }
  }
  const Real det = a[0][0] * out[0][0] + a[0][1] * out[1][0] + a[0][2] * out[2][0];
  for (Vector& row : out) {
    for (Real& element : row) element /= det;
  }
  return out;
}

TwoViews twoViews(const Camera& camera, const Motion& m) {
  const Real s = std::sin(m.pitch), c = std::cos(m.pitch);
  const Matrix k{Vector{camera.fx, 0, camera.cx}, Vector{0, camera.fy, camera.cy}, Vector{0, 0, 1}};
  // Rows: right, down and forward axes of the camera in base; the columns are x, y and the origin
  // of the floor seen from the camera at (lead, 0, height).
  const Matrix pose{Vector{0, -1, 0}, Vector{-s, 0, s * m.lead + c * m.height},
                    Vector{c, 0, -c * m.lead + s * m.height}};
  const Real sa = std::sin(m.angle), ca = std::cos(m.angle);
  const Matrix moved{Vector{ca, -sa, m.x}, Vector{sa, ca, m.y}, Vector{0, 0, 1}};
  TwoViews views;
  views.floor_to_reference = product(k, pose);
  views.floor_to_current = product(views.floor_to_reference, inverse(moved));
  views.current_to_reference = product(views.floor_to_reference, inverse(views.floor_to_current));
  const Vector foot{m.lead, 0, 1};
  views.f1 = product(views.floor_to_current, product(moved, foot));
  views.f2 = product(views.floor_to_current, foot);
  return views;
}

Real turningRadiusSquared(const Camera& camera) {
  const Real a = 21 * camera.k3, b = 10 * camera.k2, c = 3 * camera.k1;  // of the derivative
  const auto f = [&](Real q) {
    return 1 + q * (3 * camera.k1 + q * (5 * camera.k2 + q * 7 * camera.k3));
  };
  std::vector<Real> ends{0};
  if (a == 0 && b != 0) ends.push_back(-c / b);
  if (a != 0 && b * b - 4 * a * c >= 0) {
    ends.push_back((-b - std::sqrt(b * b - 4 * a * c)) / (2 * a));
    ends.push_back((-b + std::sqrt(b * b - 4 * a * c)) / (2 * a));
  }
  ends.push_back(1e6L);  // far above the widest r2
  std::sort(ends.begin(), ends.end());
  for (size_t i = 1; i < ends.size(); ++i) {
    Real low = std::max(ends[i - 1], 0.0L), high = ends[i];
    if (high <= low || f(high) > 0) continue;
    for (int n = 0; n < 200; ++n) {
      const Real middle = (low + high) / 2;
      (f(middle) > 0 ? low : high) = middle;
    }
    return high;
  }
  return infinity;
}

int r2Max(const Camera& camera) {
  const Real scaled = 65536 * turningRadiusSquared(camera);
  return scaled >= 16777215 ? 16777215 : static_cast<int>(std::floor(scaled));
}

namespace {

bool samplesInside(const Camera& camera, Real u, Real v) {
  const Real x = (u - camera.cx) / camera.fx, y = (v - camera.cy) / camera.fy;
  const Real r2 = x * x + y * y;
  if (r2 > turningRadiusSquared(camera)) return false;
  const Real factor = 1 + r2 * (camera.k1 + r2 * (camera.k2 + r2 * camera.k3));
  const Real ud = x * factor * camera.fx + camera.cx, vd = y * factor * camera.fy + camera.cy;
  return ud >= -0.5L && ud < camera.width - 0.5L && vd >= -0.5L && vd < camera.height - 0.5L;
}

}  // namespace

std::vector<GridPoint> gridPoints(const Camera& camera, const TwoViews& views) {
  const Matrix to_floor = inverse(views.floor_to_current);
  std::vector<GridPoint> points;
  for (int j = 0; j <= 12; ++j) {
    for (int i = 0; i <= 16; ++i) {
      const int u = i * (camera.width - 1) / 16, v = j * (camera.height - 1) / 12;
      const Vector pixel{static_cast<Real>(u), static_cast<Real>(v), 1};
      const Vector seen = product(views.current_to_reference, pixel);
      if (product(to_floor, pixel)[2] <= 0 || seen[2] <= 0) continue;
      const Real x = seen[0] / seen[2], y = seen[1] / seen[2];
      if (!samplesInside(camera, u, v) || !samplesInside(camera, x, y)) continue;
      points.push_back(GridPoint{u, v, x, y});
    }
  }
  return points;
}

Real quantisationError(const Coefficients& h, const std::vector<GridPoint>& points) {
  Real worst = 0;
  for (const GridPoint& p : points) {
    const auto row = [&](size_t i) {
      return static_cast<Real>(h[i]) * p.u + static_cast<Real>(h[i + 1]) * p.v +
             16 * static_cast<Real>(h[i + 2]);
    };
    if (row(6) <= 0) return infinity;
    worst = std::max(worst, std::hypot(row(0) / row(6) - p.x, row(3) / row(6) - p.y));
  }
  return worst;
}

bool quantise(const Matrix& g, Real scale, Coefficients& h) {
  for (size_t i = 0; i < 9; ++i) {
    const Real fraction = i % 3 == 2 ? 128 : 2048;
    const Real value = nearest(g[i / 3][i % 3] * scale * fraction);
    if (!fitsSigned(value, 18)) return false;
    h[i] = static_cast<int>(value);
  }
  return true;
}

Real largestPowerOfTwo(const Matrix& g) {
  Coefficients h;
  for (int e = 100; e > -100; --e) {
    if (quantise(g, std::ldexp(1.0L, e), h)) return std::ldexp(1.0L, e);
  }
  return 0;
}

namespace {

/// Rule 3: errors are ranked after rounding to 2^-20 px.
Real rank(Real error) { return std::isinf(error) ? error : nearest(std::ldexp(error, 20)); }

void polish(Fit& fit, const std::vector<GridPoint>& points) {
  for (bool lowered = true; lowered;) {
    lowered = false;
    Fit best = fit;
    for (size_t i = 0; i < 9; ++i) {
      for (const int change : {-1, 1}) {
        Fit next = fit;
        next.h[i] += change;
        if (!fitsSigned(next.h[i], 18)) continue;
        next.error = quantisationError(next.h, points);
        if (rank(next.error) < rank(best.error)) best = next;
      }
    }
    if (rank(best.error) < rank(fit.error)) {
      fit = best;
      lowered = true;
    }
  }
}

bool better(const Fit& a, const Fit& b) { return rank(a.error) < rank(b.error); }

}  // namespace

Fit fitHomography(const Camera& camera, const TwoViews& views) {
  const std::vector<GridPoint> points = gridPoints(camera, views);
  if (points.empty()) return Fit{};
  const Real s = largestPowerOfTwo(views.current_to_reference);
  std::vector<Fit> fits;
  for (int j = 0; j <= 767; ++j) {
    Fit fit;
    const Real scale = s / 2 * std::pow(4.0L, static_cast<Real>(j) / 767);
    if (!quantise(views.current_to_reference, scale, fit.h)) continue;
    fit.error = quantisationError(fit.h, points);
    fit.usable = !std::isinf(fit.error);
    if (fit.usable) fits.push_back(fit);
  }
  std::stable_sort(fits.begin(), fits.end(), better);
  if (fits.size() > 8) fits.resize(8);
  for (Fit& fit : fits) polish(fit, points);
  const auto best = std::min_element(fits.begin(), fits.end(), better);
  return best == fits.end() ? Fit{} : *best;
}

std::array<int, 3> horizonCoefficients(const TwoViews& views) {
  const Vector row = inverse(views.floor_to_current)[2];
  const Matrix only{Vector{0, 0, 0}, Vector{0, 0, 0}, row};
  Coefficients h{};
  quantise(only, largestPowerOfTwo(only), h);
  return {h[6], h[7], h[8]};
}

namespace {

/// One axis of the clamp: from `start` along `direction` to the limit on that side.
struct Axis {
  Real start, direction;
  Real limit() const { return direction > 0 ? 8191 : -8192; }
  Real room() const { return direction == 0 ? infinity : (limit() - start) / direction; }
};

/// The value of `axis` where `first` meets its limit; one rounding, in the division.
Real valueWhere(const Axis& first, const Axis& axis) {
  const Real whole = axis.start * first.direction + (first.limit() - first.start) * axis.direction;
  return whole / first.direction;
}

}  // namespace

Vector midFoot(const TwoViews& views) {
  const Vector &a = views.f1, &b = views.f2;
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Vector meanPixel(const TwoViews& views) {
  const Vector &a = views.f1, &b = views.f2;
  if (a[2] <= 0 || b[2] <= 0) return midFoot(views);
  return {(a[0] / a[2] + b[0] / b[2]) / 2, (a[1] / a[2] + b[1] / b[2]) / 2, 1};
}

Focus focusWord(const Vector& f, int width, int height) {
  const Real cu = (width - 1) / 2.0L, cv = (height - 1) / 2.0L;
  const Real tu = f[0] - f[2] * cu, tv = f[1] - f[2] * cv;
  Focus focus;
  if (tv <= 0) return focus;
  if (f[2] != 0) {
    focus.exact_u = f[0] / f[2];
    focus.exact_v = f[1] / f[2];
    const Real u = nearest(focus.exact_u), v = nearest(focus.exact_v);
    focus.usable = fitsSigned(u, 14) && fitsSigned(v, 14) && std::abs(v) >= 1;
    focus.u = focus.usable ? static_cast<int>(u) : 0;
    focus.v = focus.usable ? static_cast<int>(v) : 0;
    if (focus.usable) return focus;
  }
  const int sign = f[2] < 0 ? -1 : 1;
  const Axis along_u{cu, sign * tu}, along_v{cv, sign * tv};
  const Axis& first = along_u.room() < along_v.room() ? along_u : along_v;
  focus.clamped = true;
  focus.exact_u = valueWhere(first, along_u);
  focus.exact_v = valueWhere(first, along_v);
  focus.u = static_cast<int>(std::trunc(focus.exact_u));
  focus.v = static_cast<int>(std::trunc(focus.exact_v));
  focus.usable = std::abs(focus.v) >= 1;
  return focus;
}

}  // namespace oracle
