#include "ipm_mapping/fpga/focus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ipm_mapping::fpga {
namespace {

using formats::FocusCoordinate;
constexpr double lowest = FocusCoordinate::lowest();
constexpr double highest = FocusCoordinate::highest();

bool fitsWord(double value) { return value >= lowest && value <= highest; }

/// The rounded focus, where it fits.
QuantisedFocus direct(const Eigen::Vector3d& f) {
  QuantisedFocus out;
  if (f.z() == 0.0) return out;
  const double u = std::round(f.x() / f.z()), v = std::round(f.y() / f.z());
  if (!fitsWord(u) || !fitsWord(v) || std::abs(v) < 1.0) return out;
  out.word = {static_cast<int>(u), static_cast<int>(v)};
  out.usable = true;
  return out;
}

/// One component's way to its limit.
struct Reach {
  double limit, lambda;
};

Reach reach(double centre, double direction) {
  if (direction == 0.0) return {centre, std::numeric_limits<double>::infinity()};
  const double limit = direction > 0.0 ? highest : lowest;
  return {limit, (limit - centre) / direction};
}

QuantisedFocus clamped(const Eigen::Vector2d& centre, const Eigen::Vector2d& direction) {
  const Reach u = reach(centre.x(), direction.x());
  const Reach v = reach(centre.y(), direction.y());
  const double lambda = std::min(u.lambda, v.lambda);
  const auto component = [lambda](const Reach& r, double c, double t) {
    return r.lambda == lambda ? r.limit : std::trunc(c + lambda * t);
  };
  QuantisedFocus out;
  out.word = {static_cast<int>(component(u, centre.x(), direction.x())),
              static_cast<int>(component(v, centre.y(), direction.y()))};
  out.clamped = true;
  out.usable = out.word.v != 0;
  return out;
}

}  // namespace

QuantisedFocus quantiseFocus(const Focus& focus, int width, int height) {
  const Eigen::Vector3d& f = focus.f;
  const Eigen::Vector2d centre(0.5 * (width - 1), 0.5 * (height - 1));
  const Eigen::Vector2d t = focus.direction(centre.x(), centre.y());
  if (!f.allFinite() || !(t.y() > 0.0)) return {};
  const QuantisedFocus fitting = direct(f);
  if (fitting.usable) return fitting;
  return clamped(centre, f.z() < 0.0 ? Eigen::Vector2d(-t) : t);
}

}  // namespace ipm_mapping::fpga
