#include "ipm_mapping/fpga/homography_quantiser.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ipm_mapping::fpga {
namespace {

constexpr int scale_count = 768;
constexpr int polished_count = 8;
constexpr double error_units = 1 << 20;  // rule 3: errors are ranked after rounding to 2^-20 px
constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

bool isOffset(std::size_t i) { return i % 3 == 2; }

/// scale * G in the registers' units, rounded; nothing when a coefficient does not fit.
std::optional<HomographyWords> rounded(const Eigen::Matrix3d& G, double scale,
                                       CoefficientFormat format) {
  HomographyWords words{};
  for (std::size_t i = 0; i < words.size(); ++i) {
    const double value =
        std::round(G(static_cast<int>(i / 3), static_cast<int>(i % 3)) * scale * format.unit(i));
    if (!format.fits(i, value)) return std::nullopt;
    words[i] = static_cast<std::int32_t>(value);
  }
  return words;
}

/// Exponent of the largest power of two for which `fits` holds.
template <class Fits>
std::optional<int> largestExponent(Fits&& fits) {
  constexpr int range = 64;
  for (int exponent = range; exponent >= -range; --exponent) {
    if (fits(std::ldexp(1.0, exponent))) return exponent;
  }
  return std::nullopt;
}

struct Candidate {
  std::int64_t error = no_limit;
  double scale = 0.0;
  HomographyWords words{};
};

/// The best scales in rising error; the first one wins among equals.
class Ranking {
 public:
  [[nodiscard]] std::int64_t limit() const {
    return size_ < polished_count ? no_limit : best_[polished_count - 1].error;
  }
  void insert(const Candidate& candidate) {
    std::size_t at = size_ < polished_count ? size_++ : polished_count - 1;
    for (; at > 0 && candidate.error < best_[at - 1].error; --at) best_[at] = best_[at - 1];
    best_[at] = candidate;
  }
  [[nodiscard]] const Candidate* begin() const { return best_.data(); }
  [[nodiscard]] const Candidate* end() const { return best_.data() + size_; }

 private:
  std::array<Candidate, polished_count> best_;
  std::size_t size_ = 0;
};

Ranking searchScales(const Eigen::Matrix3d& G, double power_of_two, CoefficientFormat format,
                     ErrorGrid& grid) {
  Ranking ranking;
  for (int j = 0; j < scale_count; ++j) {
    const double scale = power_of_two / 2.0 * std::pow(4.0, j / (scale_count - 1.0));
    const auto words = rounded(G, scale, format);
    if (!words) continue;
    if (const auto error = grid.error(*words, ranking.limit())) {
      ranking.insert({*error, scale, *words});
    }
  }
  return ranking;
}

/// One step of the polish: the best of the 18 neighbours, if it is better. Row-major, -1 first.
bool improve(Candidate& candidate, CoefficientFormat format, ErrorGrid& grid) {
  Candidate best = candidate;
  for (std::size_t i = 0; i < candidate.words.size(); ++i) {
    for (const int change : {-1, 1}) {
      HomographyWords words = candidate.words;
      words[i] += change;
      if (!format.fits(i, words[i])) continue;
      if (const auto error = grid.error(words, best.error)) {
        best.error = *error;
        best.words = words;
      }
    }
  }
  const bool improved = best.error < candidate.error;
  candidate = best;
  return improved;
}

QuantisedHomography result(const Candidate& candidate, int steps) {
  return {candidate.words, static_cast<double>(candidate.error) / error_units, candidate.scale,
          steps};
}

}  // namespace

double CoefficientFormat::unit(std::size_t i) const {
  return std::ldexp(1.0, isOffset(i) ? offset : linear);
}

bool CoefficientFormat::fits(std::size_t i, double rounded) const {
  const int integer_bits = isOffset(i) ? formats::HomographyOffset::integer_bits
                                       : formats::HomographyLinear::integer_bits;
  const double limit = std::ldexp(unit(i), integer_bits - 1);
  return rounded >= -limit && rounded <= limit - 1.0;
}

ErrorGrid::ErrorGrid(const GroundView& view, const Eigen::Matrix3d& G, CoefficientFormat format)
    : format_(format) {
  const CameraModel& camera = view.camera;
  const Distortion& d = camera.distortion();
  const CameraModel lens(camera.intrinsics(), {d.k1, d.k2, 0.0, 0.0, d.k3});
  const GroundProjection floor(view.H_c());
  const auto seen = [&lens](double u, double v) {
    double x = 0.0, y = 0.0;
    return lens.distortPixel(u, v, x, y) && x >= -0.5 && x < lens.width() - 0.5 && y >= -0.5 &&
           y < lens.height() - 0.5;
  };
  for (int i = 0; i < capacity; ++i) {
    const int u = i % columns * (lens.width() - 1) / (columns - 1);
    const int v = i / columns * (lens.height() - 1) / (rows - 1);
    const Eigen::Vector3d g = G * Eigen::Vector3d(u, v, 1.0);
    if (!(floor.inverseDepth(u, v) > 0.0) || !(g.z() > 0.0)) continue;
    const Eigen::Vector2d target = g.hnormalized();
    if (seen(u, v) && seen(target.x(), target.y())) add(u, v, target);
  }
  pad();
}

void ErrorGrid::add(double u, double v, const Eigen::Vector2d& target) {
  const auto i = static_cast<std::size_t>(size_++);
  u_[i] = u;
  v_[i] = v;
  x_[i] = target.x();
  y_[i] = target.y();
}

/// Fills the last group with copies of a point, which change no maximum.
void ErrorGrid::pad() {
  for (auto i = static_cast<std::size_t>(size_); size_ > 0 && i < padded; ++i) {
    u_[i] = u_[0];
    v_[i] = v_[0];
    x_[i] = x_[0];
    y_[i] = y_[0];
  }
}

/// The group that refused a candidate is likely to refuse the next one.
void ErrorGrid::moveToFront(std::size_t worst) {
  for (auto* array : {&u_, &v_, &x_, &y_}) {
    std::swap_ranges(array->begin(), array->begin() + group,
                     array->begin() + static_cast<std::ptrdiff_t>(worst));
  }
}

std::optional<std::int64_t> ErrorGrid::error(const HomographyWords& words, std::int64_t limit) {
  std::array<double, 9> h;
  for (std::size_t i = 0; i < h.size(); ++i) h[i] = words[i] / format_.unit(i);
  const double bound = static_cast<double>(limit) / error_units;
  double worst = 0.0;
  for (std::size_t first = 0; first < static_cast<std::size_t>(size_); first += group) {
    double lowest_d = std::numeric_limits<double>::infinity(), highest = 0.0;
    for (std::size_t i = first; i < first + group; ++i) {
      const double d = h[6] * u_[i] + h[7] * v_[i] + h[8];
      const double dx = (h[0] * u_[i] + h[1] * v_[i] + h[2]) / d - x_[i];
      const double dy = (h[3] * u_[i] + h[4] * v_[i] + h[5]) / d - y_[i];
      const double squared = dx * dx + dy * dy;
      lowest_d = d < lowest_d ? d : lowest_d;
      highest = squared > highest ? squared : highest;
    }
    if (!(lowest_d > 0.0)) return std::nullopt;
    worst = std::max(worst, highest);
    if (std::sqrt(worst) < bound) continue;
    if (first > 0) moveToFront(first);
    return std::nullopt;
  }
  const double units = std::round(std::sqrt(worst) * error_units);
  if (!(units < static_cast<double>(limit))) return std::nullopt;
  return static_cast<std::int64_t>(units);
}

std::optional<QuantisedHomography> quantiseHomography(const GroundView& view,
                                                      CoefficientFormat format) {
  const Eigen::Matrix3d G = view.G();
  ErrorGrid grid(view, G, format);
  const auto exponent = largestExponent([&](double scale) { return rounded(G, scale, format); });
  if (grid.size() == 0 || !exponent) return std::nullopt;
  const Ranking ranking = searchScales(G, std::ldexp(1.0, *exponent), format, grid);
  std::optional<QuantisedHomography> best;
  std::int64_t best_error = no_limit;
  for (Candidate candidate : ranking) {
    int steps = 0;
    while (improve(candidate, format, grid)) ++steps;
    if (candidate.error >= best_error) continue;
    best_error = candidate.error;
    best = result(candidate, steps);
  }
  return best;
}

std::optional<QuantisedHomography> quantiseAtPowerOfTwo(const GroundView& view) {
  const Eigen::Matrix3d G = view.G();
  ErrorGrid grid(view, G);
  const auto exponent = largestExponent([&G](double scale) { return rounded(G, scale, {}); });
  if (grid.size() == 0 || !exponent) return std::nullopt;
  Candidate candidate;
  candidate.scale = std::ldexp(1.0, *exponent);
  candidate.words = *rounded(G, candidate.scale, {});
  const auto error = grid.error(candidate.words, no_limit);
  if (!error) return std::nullopt;
  candidate.error = *error;
  return result(candidate, 0);
}

std::array<std::int32_t, 3> quantiseHorizon(const GroundView& view) {
  const Eigen::Vector3d row = view.H_c().inverse().row(2).transpose();
  const auto scaled = [&row](double scale) {
    std::array<double, 3> words{};
    for (std::size_t i = 0; i < 3; ++i) {
      words[i] = std::round(row(static_cast<int>(i)) * scale * CoefficientFormat{}.unit(i));
    }
    return words;
  };
  const auto exponent = largestExponent([&scaled](double scale) {
    const auto words = scaled(scale);
    return CoefficientFormat{}.fits(0, words[0]) && CoefficientFormat{}.fits(1, words[1]) &&
           CoefficientFormat{}.fits(2, words[2]);
  });
  const auto words = scaled(std::ldexp(1.0, exponent.value_or(0)));
  return {static_cast<std::int32_t>(words[0]), static_cast<std::int32_t>(words[1]),
          static_cast<std::int32_t>(words[2])};
}

}  // namespace ipm_mapping::fpga
