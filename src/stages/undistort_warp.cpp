#include "ipm_mapping/stages/undistort_warp.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping {
namespace {

// Rows between two exact rows of the map. Vertical interpolation over 8 rows errs by less than
// 0.01 px at VGA with the widest lens of the tests; over 16 rows by 0.04 px.
constexpr int key_row_step = 8;
constexpr int fraction_bits = 8;
constexpr int one = 1 << fraction_bits;

std::int32_t toFixed(double coordinate) {
  return static_cast<std::int32_t>(std::lround(coordinate * one));
}

/// Weighted mean of the 2x2 pixels from p on, weights in 1/256, rounded.
inline std::uint8_t bilinear(const std::uint8_t* p, std::ptrdiff_t stride, int fu, int fv) {
  const int top = p[0] * (one - fu) + p[1] * fu;
  const int bottom = p[stride] * (one - fu) + p[stride + 1] * fu;
  return static_cast<std::uint8_t>((top * (one - fv) + bottom * fv + (one * one / 2)) >>
                                   (2 * fraction_bits));
}

/// A sample at the last row or column has no neighbour to its right or below, but weight 0 there:
/// step one pixel back and use the full fraction instead.
struct Corner {
  int pixel;
  int fraction;
};
inline Corner cornerOf(std::int32_t fixed, int size) {
  const int pixel = std::min(fixed >> fraction_bits, size - 2);
  return {pixel, fixed - (pixel << fraction_bits)};
}

}  // namespace

UndistortWarp::UndistortWarp(const CameraModel& camera) : camera_(camera) {
  const int W = camera.width(), H = camera.height();
  for (KeyRow* key : {&above_, &below_}) {
    key->u.resize(static_cast<std::size_t>(W));
    key->v.resize(static_cast<std::size_t>(W));
    key->valid.resize(static_cast<std::size_t>(W));
  }
  row_u_.resize(static_cast<std::size_t>(W));
  row_v_.resize(static_cast<std::size_t>(W));
  fixed_.reserve(static_cast<std::size_t>(W) * static_cast<std::size_t>(H));
  for (int v = 0; v < H; ++v) {
    for (int u = 0; u < W; ++u) {
      double ur = 0, vr = 0;
      FixedSample sample{-1, 0, 0};
      if (camera.distortPixel(u, v, ur, vr)) {
        const std::int32_t fu = toFixed(ur), fv = toFixed(vr);
        if (fu >= 0 && fv >= 0 && fu <= (W - 1) * one && fv <= (H - 1) * one) {
          const Corner cu = cornerOf(fu, W), cv = cornerOf(fv, H);
          sample = {cv.pixel * W + cu.pixel, static_cast<std::uint16_t>(cu.fraction),
                    static_cast<std::uint16_t>(cv.fraction)};
        }
      }
      fixed_.push_back(sample);
    }
  }
}

void UndistortWarp::undistort(GrayView raw, GrayBuffer undistorted, GrayBuffer valid) const {
  const int W = raw.width;
  const FixedSample* sample = fixed_.data();
  for (int v = 0; v < raw.height; ++v) {
    std::uint8_t* out = undistorted.row(v);
    std::uint8_t* seen = valid.row(v);
    for (int u = 0; u < W; ++u, ++sample) {
      if (sample->offset < 0) {
        out[u] = seen[u] = 0;
        continue;
      }
      const std::uint8_t* p = raw.data + (sample->offset / W) * raw.stride + sample->offset % W;
      out[u] = bilinear(p, raw.stride, sample->fraction_u, sample->fraction_v);
      seen[u] = 255;
    }
  }
}

bool UndistortWarp::Map::exact(double u, double v, double& u_raw, double& v_raw) const {
  if (!(horizon.x() * u + horizon.y() * v + horizon.z() > 0.0)) return false;
  const Eigen::Vector3d p = to_normalized * Eigen::Vector3d(u, v, 1.0);
  if (!(p.z() > 0.0)) return false;
  if (!camera->distortNormalized(p.x() / p.z(), p.y() / p.z(), u_raw, v_raw)) return false;
  return u_raw >= 0.0 && v_raw >= 0.0 && u_raw <= camera->width() - 1.0 &&
         v_raw <= camera->height() - 1.0;
}

UndistortWarp::Map UndistortWarp::map(const GroundView& view) {
  // G keeps the scale in which the third component is the ratio of both depths, so its sign tells
  // whether the point is in front of the reference camera once it is in front of the current one.
  return {&view.camera, view.camera.intrinsics().matrix().inverse() * view.G(),
          view.currentFloor().inverse().row(2)};
}

void UndistortWarp::fillKeyRow(const Map& map, int v, KeyRow& key) const {
  for (int u = 0; u < camera_.width(); ++u) {
    const auto i = static_cast<std::size_t>(u);
    double ur = 0, vr = 0;
    key.valid[i] = map.exact(u, v, ur, vr);
    key.u[i] = static_cast<float>(ur);
    key.v[i] = static_cast<float>(vr);
  }
}

void UndistortWarp::interpolateRow(const Map& map, int v, float t, const KeyRow& above,
                                   const KeyRow& below) {
  const auto W = static_cast<std::size_t>(camera_.width());
  for (std::size_t u = 0; u < W; ++u) {
    // +0.5 and truncation rounds to nearest: interpolated coordinates are not negative.
    row_u_[u] =
        static_cast<std::int32_t>((above.u[u] + (below.u[u] - above.u[u]) * t) * one + 0.5F);
    row_v_[u] =
        static_cast<std::int32_t>((above.v[u] + (below.v[u] - above.v[u]) * t) * one + 0.5F);
  }
  // Where a key row leaves the picture or meets the horizon, only the exact map will do.
  for (std::size_t u = 0; u < W; ++u) {
    if (above.valid[u] && below.valid[u]) continue;
    double ur = 0, vr = 0;
    const bool seen = map.exact(static_cast<double>(u), v, ur, vr);
    row_u_[u] = seen ? toFixed(ur) : -1;
    row_v_[u] = seen ? toFixed(vr) : -1;
  }
}

void UndistortWarp::sampleRow(GrayView raw, std::uint8_t* out, std::uint8_t* valid) const {
  for (int u = 0; u < raw.width; ++u) {
    const std::int32_t fu = row_u_[static_cast<std::size_t>(u)];
    const std::int32_t fv = row_v_[static_cast<std::size_t>(u)];
    if (fu < 0) {
      out[u] = valid[u] = 0;
      continue;
    }
    const Corner cu = cornerOf(fu, raw.width), cv = cornerOf(fv, raw.height);
    out[u] = bilinear(raw.row(cv.pixel) + cu.pixel, raw.stride, cu.fraction, cv.fraction);
  }
}

void UndistortWarp::warp(GrayView raw_reference, const GroundView& view, GrayBuffer warped,
                         GrayBuffer valid) {
  const Map exact_map = map(view);
  const int H = raw_reference.height;
  fillKeyRow(exact_map, 0, below_);
  for (int key = 0; key < H; key += key_row_step) {
    std::swap(above_, below_);
    const int next = std::min(key + key_row_step, H - 1);
    fillKeyRow(exact_map, next, below_);
    const int rows = std::max(next - key, 1);
    const int end = next == H - 1 ? H : next;
    for (int v = key; v < end; ++v) {
      interpolateRow(exact_map, v, static_cast<float>(v - key) / static_cast<float>(rows), above_,
                     below_);
      sampleRow(raw_reference, warped.row(v), valid.row(v));
    }
    if (end == H) break;
  }
}

}  // namespace ipm_mapping
