#include "ipm_mapping/stages/polar_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {
namespace {

// A focus farther away than this, pixels, is as good as at infinity: over a picture's height the
// lines' directions differ by less than a thousandth of a pixel.
constexpr double farthest_focus = 1e7;

// Lines of the full view flatter than this, columns a row, are left out: they would leave holes,
// and around a focus inside the picture there is no end to them.
constexpr double max_slope = 4.0;

// More than any line of a beam is ever to the left of the picture, columns.
constexpr int lift = 1 << 24;

/// The focus in whole pixels, for Bresenham; one at infinity, where a level camera's lies but for
/// rounding, is moved along the line through the picture's centre.
struct WholePixel {
  long u, v;
};
WholePixel wholePixel(const Focus& focus, int width, int height) {
  const Eigen::Vector2d centre(0.5 * (width - 1), 0.5 * (height - 1));
  const Eigen::Vector2d direction = focus.direction(centre.x(), centre.y());
  const double w = focus.f.z();
  // focus = centre + direction / w
  Eigen::Vector2d offset = direction * (farthest_focus / direction.norm()) * (w < 0.0 ? -1.0 : 1.0);
  if (std::abs(w) * farthest_focus > direction.norm()) offset = direction / w;
  const Eigen::Vector2d pixel = centre + offset;
  return {std::lround(pixel.x()), std::lround(pixel.y())};
}

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
  columns_.resize(static_cast<std::size_t>(n_lines) * static_cast<std::size_t>(height));
  if (!focus.f.allFinite() || !(focus.direction(0, 0).y() > 0.0)) return false;
  if (kind == Beam::FullView) return aimFullView(focus);
  return aimSource(focus);
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
  if (focus.f.z() > 0.0) {
    left = std::max(left, (focus.f.x() - max_slope * focus.f.y()) / focus.f.z());
    right = std::min(right, (focus.f.x() + max_slope * focus.f.y()) / focus.f.z());
  }
  for (int i = 0; i < lines_; ++i) {
    const double start = left + (right - left) * (i + 0.5) / lines_;
    const Eigen::Vector2d d = focus.direction(start, 0.0);
    const double slope = d.x() / d.y();
    std::int16_t* column = writableColumns(i);
    for (int v = 0; v < end; ++v) {
      // Conversion cuts towards zero: lifted, that is down on either side of it.
      const int u = static_cast<int>(start + slope * v + (lift + 0.5)) - lift;
      column[v] = static_cast<std::int16_t>(u >= 0 && u < width_ ? u : outside);
    }
    std::fill(column + end, column + height_, outside);
  }
  return true;
}

bool PolarBeam::aimSource(const Focus& focus) {
  const auto [focus_u, focus_v] = wholePixel(focus, width_, height_);
  if (focus_v == 0) return false;
  const int end_row = endRow(focus);
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
      column[v] = static_cast<std::int16_t>(u >= 0 && u < width_ ? u : outside);
    }
    std::fill(column + end_row, column + height_, outside);
  }
  return end_row > 0;
}

void PolarBeam::sample(GrayView obstacle_mask) {
  values_.resize(columns_.size());
  const std::int16_t* column = columns_.data();
  std::uint8_t* value = values_.data();
  for (int i = 0; i < lines_; ++i, column += height_, value += height_) {
    const std::uint8_t* row = obstacle_mask.data;
    for (int v = 0; v < height_; ++v, row += obstacle_mask.stride)
      value[v] = column[v] == outside ? mask::unseen : row[column[v]];
  }
}

void PolarHistogram::count(const PolarBeam& beam) {
  const auto n = static_cast<std::size_t>(beam.lines());
  obstacle.assign(n, 0);
  seen.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint8_t* values = beam.values(static_cast<int>(i));
    int obstacles = 0, unseen = 0;
    for (int v = 0; v < beam.height(); ++v) {
      obstacles += values[v] == mask::obstacle;
      unseen += values[v] == mask::unseen;
    }
    obstacle[i] = obstacles;
    seen[i] = beam.height() - unseen;
  }
}

}  // namespace ipm_mapping
