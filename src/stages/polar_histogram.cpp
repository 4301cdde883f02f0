#include "ipm_mapping/stages/polar_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {
namespace {

// A beam narrower than this around the focus row is too steep to tell bearings apart.
constexpr double min_slope_height = 1.0;

}  // namespace

int PolarBeam::endRow(const Focus& focus) const {
  // f_v - f_w v > 0 holds above the focus; with f_w <= 0 it holds on every row below row 0 too.
  for (int v = height_ - 1; v >= 0; --v)
    if (focus.direction(0, v).y() > 0.0) return v + 1;
  return 0;
}

bool PolarBeam::aim(const Focus& focus, int width, int height, int n_lines, Beam kind) {
  lines_ = n_lines;
  width_ = width;
  height_ = height;
  columns_.assign(static_cast<std::size_t>(n_lines) * static_cast<std::size_t>(height), outside);
  if (!focus.f.allFinite() || !(focus.direction(0, 0).y() > 0.0)) return false;
  if (kind == Beam::FullView) return aimFullView(focus);
  const auto pixel = focus.pixel();
  if (!pixel || std::abs(pixel->y()) < min_slope_height) return aimFullView(focus);
  aimSource(focus, endRow(focus));
  return true;
}

bool PolarBeam::aimFullView(const Focus& focus) {
  const int end = endRow(focus);
  if (end <= 0) return false;
  // Where the lines through the last scanned row's corners start on row 0: the beam spans these
  // and the first row itself.
  const auto startOf = [&focus](double u, double v) {
    const Eigen::Vector2d d = focus.direction(u, v);
    return u - v * d.x() / d.y();
  };
  double left = 0.0, right = width_ - 1.0;
  for (const double v : {0.0, end - 1.0}) {
    left = std::min(left, startOf(0.0, v));
    right = std::max(right, startOf(width_ - 1.0, v));
  }
  for (int i = 0; i < lines_; ++i) {
    const double start = left + (right - left) * (i + 0.5) / lines_;
    const Eigen::Vector2d d = focus.direction(start, 0.0);
    const double slope = d.x() / d.y();
    std::int16_t* column = writableColumns(i);
    for (int v = 0; v < end; ++v) {
      const double u = std::floor(start + slope * v + 0.5);
      if (u >= 0.0 && u < width_) column[v] = static_cast<std::int16_t>(u);
    }
  }
  return true;
}

void PolarBeam::aimSource(const Focus& focus, int end_row) {
  const Eigen::Vector2d pixel = *focus.pixel();
  const auto focus_u = static_cast<long>(std::lround(pixel.x()));
  const auto focus_v = static_cast<long>(std::lround(pixel.y()));
  for (int i = 0; i < lines_; ++i) {
    // 8i + 4 of a row of 640 pixels with 80 lines; the same spacing for other sizes.
    const long start = (2L * i + 1) * width_ / (2L * lines_);
    const long du = std::labs(focus_u - start), dv = std::labs(focus_v);
    long step = focus_u > start ? 1 : (focus_u < start ? -1 : 0);
    if (focus_v < 0) step = -step;
    long u = start, d = 2 * du - dv;
    std::int16_t* column = writableColumns(i);
    for (int v = 0; v < end_row; ++v) {
      if (d > 0) {
        u += step;
        d += 2 * du - 2 * dv;
      } else {
        d += 2 * du;
      }
      if (u >= 0 && u < width_) column[v] = static_cast<std::int16_t>(u);
    }
  }
}

void PolarHistogram::count(const PolarBeam& beam, GrayView obstacle_mask) {
  const auto n = static_cast<std::size_t>(beam.lines());
  obstacle.assign(n, 0);
  seen.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int16_t* column = beam.columns(static_cast<int>(i));
    for (int v = 0; v < beam.height(); ++v) {
      if (column[v] == PolarBeam::outside) continue;
      const std::uint8_t value = obstacle_mask.at(column[v], v);
      obstacle[i] += value == mask::obstacle;
      seen[i] += value != mask::unseen;
    }
  }
}

}  // namespace ipm_mapping
