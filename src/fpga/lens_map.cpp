#include <cmath>
#include <cstring>

#include "ipm_mapping/fpga/fast_engine.hpp"

namespace ipm_mapping::fpga {
namespace {

constexpr Integer fits_32_bits = std::int64_t{1} << 30;

/// Whether every intermediate of rule 4 fits 32 bits for r2 <= r2_max, with room to spare.
bool isNarrow(const FrameParameters& p) {
  const double r2 = static_cast<double>(p.r2_max) / 65536.0;
  double bound = 32.0 * static_cast<double>(std::abs(p.k3));
  for (const Integer k : {32 * std::abs(p.k2), 32 * std::abs(p.k1), Integer{65536}}) {
    bound = bound * r2 + 1.0 + static_cast<double>(k);
    if (bound > static_cast<double>(fits_32_bits)) return false;
  }
  const double normalized = std::sqrt(r2 + 1.0) * 65536.0 + 1.0;
  const double distorted = normalized * bound / 65536.0 + 1.0;
  const auto f = static_cast<double>(std::max(p.fx, p.fy));
  const auto limit = static_cast<double>(fits_32_bits);
  return distorted <= limit && distorted * f / 65536.0 + 65537.0 <= limit;
}

/// The fields that the map depends on.
FrameParameters lensOnly(const FrameParameters& p) {
  FrameParameters key;
  key.width = p.width;
  key.height = p.height;
  key.fx = p.fx;
  key.fy = p.fy;
  key.cx = p.cx;
  key.cy = p.cy;
  key.k1 = p.k1;
  key.k2 = p.k2;
  key.k3 = p.k3;
  key.r2_max = p.r2_max;
  return key;
}

bool sameLens(const FrameParameters& a, const FrameParameters& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.k3 == b.k3 &&
         a.r2_max == b.r2_max;
}

}  // namespace

LensConstants lensConstants(const FrameParameters& p) {
  LensConstants c{};
  c.fx = static_cast<std::int32_t>(p.fx);
  c.fy = static_cast<std::int32_t>(p.fy);
  c.cx = static_cast<std::int32_t>(p.cx);
  c.cy = static_cast<std::int32_t>(p.cy);
  c.k1 = static_cast<std::int32_t>(p.k1 * 32);
  c.k2 = static_cast<std::int32_t>(p.k2 * 32);
  c.k3 = static_cast<std::int32_t>(p.k3 * 32);
  c.r2_max = static_cast<std::int32_t>(p.r2_max);
  c.x_scale = 65536.0F / static_cast<float>(c.fx);
  c.y_scale = 65536.0F / static_cast<float>(c.fy);
  c.narrow = isNarrow(p);
  return c;
}

void LensMap::prepare(const FrameParameters& p, std::ptrdiff_t stride, const FastKernels& kernels) {
  if (stride == stride_ && sameLens(p, key_)) return;
  key_ = lensOnly(p);
  stride_ = stride;
  counts_ = {};
  const int width = static_cast<int>(p.width), height = static_cast<int>(p.height);
  valid_.ensure(width, height);
  x_.ensure(width, height);
  y_.ensure(width, height);
  runs_.clear();
  first_run_.assign(1, 0);
  for (int v = 0; v < height; ++v) {
    makeRow(p, stride, v, kernels);
    first_run_.push_back(runs_.size());
  }
}

void LensMap::makeRow(const FrameParameters& p, std::ptrdiff_t stride, int v,
                      const FastKernels& kernels) {
  const int width = static_cast<int>(p.width);
  for (int u = 0; u < width; ++u) {
    row_.x[u] = u * 64;
    row_.y[u] = v * 64;
    row_.valid[u] = -1;
  }
  kernels.lens(lensConstants(p), width, row_, counts_);
  alignas(64) std::int32_t offsets[row_capacity];
  const AddressConstants address{width, static_cast<std::int32_t>(p.height),
                                 static_cast<std::int32_t>(stride), INT32_MIN};
  kernels.address(address, row_, offsets, valid_.row(v));
  appendRuns(offsets, valid_.row(v), width);
  for (int u = 0; u < width; ++u) {
    const std::int32_t x = row_.x[u], y = row_.y[u];
    const bool fits = row_.valid[u] && x >= formats::ViewCoordinate::lowest() &&
                      x <= formats::ViewCoordinate::highest() &&
                      y >= formats::ViewCoordinate::lowest() &&
                      y <= formats::ViewCoordinate::highest();
    x_.at(u, v) = fits ? x : INT32_MIN;
    y_.at(u, v) = fits ? y : INT32_MIN;
  }
}

void LensMap::appendRuns(const std::int32_t* offsets, const std::uint8_t* valid, int width) {
  for (int u = 0; u < width; ++u) {
    if (!valid[u]) continue;
    const bool continues = u > 0 && valid[u - 1] && offsets[u] == offsets[u - 1] + 1;
    if (continues) {
      ++runs_.back().length;
    } else {
      runs_.push_back({offsets[u], static_cast<std::int16_t>(u), 1});
    }
  }
}

void LensMap::fetch(const GrayView& frame, int v, std::uint8_t* out) const {
  constexpr int block = 16;  // copied whole: what lies past a run is overwritten by the next one
  const std::ptrdiff_t readable =
      static_cast<std::ptrdiff_t>(frame.height - 1) * frame.stride + frame.width;
  const auto row = static_cast<std::size_t>(v);
  for (std::size_t i = first_run_[row]; i < first_run_[row + 1]; ++i) {
    const Run run = runs_[i];
    const int rounded = (run.length + block - 1) / block * block;
    if (run.source + rounded > readable) {
      std::memcpy(out + run.target, frame.data + run.source, static_cast<std::size_t>(run.length));
      continue;
    }
    for (int k = 0; k < rounded; k += block) {
      std::memcpy(out + run.target + k, frame.data + run.source + k, block);
    }
  }
}

void LensMap::coordinates(int v, CoordinateRow& row) const {
  for (int u = 0; u < x_.width(); ++u) {
    const bool valid = x_.at(u, v) != INT32_MIN;
    row.x[u] = valid ? x_.at(u, v) : 0;
    row.y[u] = valid ? y_.at(u, v) : 0;
    row.valid[u] = valid ? -1 : 0;
  }
}

}  // namespace ipm_mapping::fpga
