#include "ipm_mapping/fpga/fast_engine.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace ipm_mapping::fpga {
namespace {

int32_t narrow32(Integer value) { return static_cast<std::int32_t>(value); }

/// Rule 3 at column 0 of row v; without a horizon every pixel passes.
HomographyRow homographyRow(const FrameParameters& p, int v) {
  HomographyRow h{};
  h.nx = narrow32(p.h12 * v + p.h13 * 16);
  h.ny = narrow32(p.h22 * v + p.h23 * 16);
  h.d = narrow32(p.h32 * v + p.h33 * 16);
  h.nx_step = narrow32(p.h11);
  h.ny_step = narrow32(p.h21);
  h.d_step = narrow32(p.h31);
  h.horizon = p.use_horizon ? narrow32(p.horizon_b * v + p.horizon_c * 16) : 1;
  h.horizon_step = p.use_horizon ? narrow32(p.horizon_a) : 0;
  return h;
}

WideHomography wideHomography(const FrameParameters& p) {
  return {{p.h11, p.h12, p.h13 * 1024, p.h21, p.h22, p.h23 * 1024, p.h31, p.h32, p.h33 * 1024}};
}

/// Rule 5: rows below this one are being overwritten while generator row v is read.
std::int32_t nearWriteBelow(const FrameParameters& p, int v) {
  const Integer overwritten = v - (p.memory_rows - p.height);
  return overwritten < 0 ? INT32_MIN : narrow32(read_write_margin + overwritten);
}

void spread(const BitRow& bits, std::uint8_t* out, int width) {
  for (int u = 0; u < width; ++u) {
    out[u] = static_cast<std::uint8_t>(bits.words[u / 64 + 1] >> (u % 64) & 1);
  }
}

}  // namespace

void RowHistogram::clear() {
  pairs_.fill(0);
  singles_.fill(0);
}

void RowHistogram::add(const std::uint8_t* row, int width) {
  int u = 0;
  for (; u + 8 <= width; u += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, row + u, 8);
    ++pairs_[eight & 0xffff];
    ++pairs_[eight >> 16 & 0xffff];
    ++pairs_[eight >> 32 & 0xffff];
    ++pairs_[eight >> 48];
  }
  for (; u < width; ++u) ++singles_[row[u]];
}

void RowHistogram::collect(GreyHistogram& bins) const {
  bins = singles_;
  for (std::size_t high = 0; high < 256; ++high) {
    const std::uint32_t* pairs = pairs_.data() + 256 * high;
    std::uint32_t sum = 0;
    for (std::size_t low = 0; low < 256; ++low) {
      sum += pairs[low];
      bins[low] += pairs[low];
    }
    bins[high] += sum;
  }
  bins[invalid_grey] = 0;
}

void FastEngine::run(const FrameInputs& inputs, const WireImages& wanted, Results& results) {
  start(inputs, wanted, results);
  std::fill_n(gaussian_, width_, invalid_grey);
  maskRow(0, gaussian_);
  erodedRow(0, eroded_);
  for (int v = 0; v < height_; ++v) {
    warpRow(v);
    differenceRow(v);
    if (v >= 2) gaussianRow(v - 1);
  }
  std::fill_n(gaussian_, width_, invalid_grey);
  maskRow(height_ - 1, gaussian_);
  std::memset(&eroded_, 0, sizeof eroded_);
  erodedRow(height_ - 1, eroded_);
  histogram_.collect(results.histogram);
  finishBeam();
}

void FastEngine::start(const FrameInputs& inputs, const WireImages& wanted, Results& results) {
  const FrameParameters& p = inputs.parameters;
  inputs_ = &inputs;
  wanted_ = &wanted;
  results_ = &results;
  width_ = static_cast<int>(p.width);
  height_ = static_cast<int>(p.height);
  threshold_ = maskThreshold(static_cast<int>(p.threshold_in), static_cast<int>(p.min_threshold));
  lens_ = lensConstants(p);
  lens_counts_ = {};
  if (p.undistort_current || p.paper_order) {
    lens_map_.prepare(p, inputs.current.stride, *kernels_);
  }
  histogram_.clear();
  std::fill_n(all_valid_, row_capacity, std::uint8_t{255});
  std::memset(&eroded_, 0, sizeof eroded_);
  startBeam();
}

void FastEngine::startBeam() {
  const FrameParameters& p = inputs_->parameters;
  const FocusWord focus{static_cast<int>(p.focus_u), static_cast<int>(p.focus_v)};
  machine_ = {narrow32(p.score_min), narrow32(p.min_height), p.method == 1};
  beam_rows_ = beamRows(focus, height_);
  std::memset(&lines_, 0, sizeof lines_);
  for (int i = 0; i < line_count; ++i) {
    const int offset = focus.u - startColumn(i);
    const int du = std::abs(offset), dv = std::abs(focus.v);
    const int sign = (offset > 0) - (offset < 0);
    lines_.u[i] = startColumn(i);
    lines_.d[i] = 2 * du - dv;  // 14-bit focus: far from saturation
    lines_.direction[i] = focus.v < 0 ? -sign : sign;
    lines_.up[i] = 2 * du - 2 * dv;
    lines_.flat[i] = 2 * du;
    lines_.smallest[i] = 2 * window_half_width + 1;
    lines_.found[i] = -1;
    if (du > dv) ++results_->overflow[Wire::BeamSlope];
  }
}

/// Rules 3-5: offsets_ and validity of the reference stream.
void FastEngine::warpRow(int v) {
  const FrameParameters& p = inputs_->parameters;
  const HomographyRow h = homographyRow(p, v);
  const AddressConstants address{
      width_, height_, static_cast<std::int32_t>(inputs_->reference.stride), nearWriteBelow(p, v)};
  std::uint8_t* valid = valid_[v % 3];
  std::int64_t near_write = 0;
  if (p.paper_order) {
    lens_map_.coordinates(v, coordinates_);
    for (int u = 0; u < width_; ++u) {
      if (h.horizon + h.horizon_step * u <= 0) coordinates_.valid[u] = 0;
    }
    kernels_->wide_homography(wideHomography(p), width_, coordinates_);
    near_write = kernels_->address(address, coordinates_, offsets_, valid);
  } else {
    near_write = kernels_->warp(h, lens_, address, coordinates_, offsets_, valid, lens_counts_);
  }
  results_->overflow[Wire::ReadWrite] += static_cast<std::uint64_t>(near_write);
}

/// Rules 6 and 7.
void FastEngine::differenceRow(int v) {
  const bool undistort = inputs_->parameters.undistort_current != 0;
  if (undistort) lens_map_.fetch(inputs_->current, v, current_);
  std::uint8_t* out = difference_[v % 3];
  std::uint8_t* valid = valid_[v % 3];
  kernels_->difference(inputs_->reference.data, offsets_,
                       undistort ? current_ : inputs_->current.row(v),
                       undistort ? lens_map_.valid(v) : all_valid_, width_, out, valid);
  if (wanted_->difference.empty()) return;
  TaggedPixel* wire = wanted_->difference.row(v);
  for (int u = 0; u < width_; ++u) wire[u] = valid[u] ? out[u] : no_correspondence;
}

void FastEngine::gaussianRow(int v) {
  kernels_->gaussian(difference_[(v - 1) % 3], difference_[v % 3], difference_[(v + 1) % 3],
                     valid_[v % 3], width_, gaussian_);
  histogram_.add(gaussian_, width_);
  maskRow(v, gaussian_);
}

void FastEngine::maskRow(int v, const std::uint8_t* gaussian) {
  BitRow& bits = masks_[static_cast<std::size_t>(v % 3)];
  kernels_->binarise(gaussian, threshold_, width_, bits);
  if (!wanted_->gaussian.empty()) {
    TaggedPixel* wire = wanted_->gaussian.row(v);
    for (int u = 0; u < width_; ++u) {
      wire[u] = gaussian[u] == invalid_grey ? no_correspondence : gaussian[u];
    }
  }
  if (!wanted_->mask.empty()) spread(bits, wanted_->mask.row(v), width_);
  if (v >= 2) erode(v - 1);
}

/// Border mask pixels are 0 by rule 8, so that border eroded pixels come out 0.
void FastEngine::erode(int v) {
  const auto columns = [this, v](int dv, int word) {
    return masks_[static_cast<std::size_t>((v + dv) % 3)].words[word];
  };
  const auto allRows = [&columns](int word) {
    return columns(-1, word) & columns(0, word) & columns(1, word);
  };
  for (int w = 1; w + 1 < bit_words; ++w) {
    const std::uint64_t middle = allRows(w);
    const std::uint64_t left = middle << 1 | allRows(w - 1) >> 63;
    const std::uint64_t right = middle >> 1 | allRows(w + 1) << 63;
    eroded_.words[w] = left & middle & right;
  }
  erodedRow(v, eroded_);
}

void FastEngine::erodedRow(int v, const BitRow& bits) {
  if (!wanted_->eroded.empty()) spread(bits, wanted_->eroded.row(v), width_);
  if (v >= beam_rows_) return;
  results_->overflow[Wire::BeamD] +=
      static_cast<std::uint64_t>(kernels_->localize(machine_, v, bits, lines_));
}

void FastEngine::finishBeam() {
  OverflowCounters& overflow = results_->overflow;
  const FrameParameters& p = inputs_->parameters;
  for (int i = 0; i < line_count; ++i) {
    const auto line = static_cast<std::size_t>(i);
    const bool open = lines_.score[i] > machine_.score_min &&
                      lines_.surface[i] > 4 * lines_.height[i] &&
                      lines_.height[i] >= machine_.min_height;
    const std::int32_t found = open ? lines_.stored[i] : lines_.found[i];
    if (found >= 0) {
      results_->cor[line] = {true, contactWord(i, found >> 9, found & 0x1ff)};
    }
    results_->bear[line] = static_cast<std::uint8_t>(std::min(lines_.bear[i], 255));
    overflow[Wire::Bear] += static_cast<std::uint64_t>(std::max(lines_.bear[i] - 255, 0));
  }
  const LensCounts& map = lens_map_.counts();
  const LensCounts& reference = p.paper_order ? map : lens_counts_;
  overflow[Wire::Xn] = static_cast<std::uint64_t>(reference.xn);
  overflow[Wire::Yn] = static_cast<std::uint64_t>(reference.yn);
  if (!p.undistort_current) return;
  overflow[Wire::XnCurrent] = static_cast<std::uint64_t>(map.xn);
  overflow[Wire::YnCurrent] = static_cast<std::uint64_t>(map.yn);
}

}  // namespace ipm_mapping::fpga
