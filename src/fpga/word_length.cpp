#include "ipm_mapping/fpga/word_length.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ipm_mapping/fpga/erosion.hpp"
#include "ipm_mapping/fpga/undistort_warp.hpp"

namespace ipm_mapping::fpga {
namespace {

/// Rules 3-5 with run-time fraction bits; 128 bits hold every intermediate.
class GenericWarp {
 public:
  GenericWarp(const GroundView& view, const FrameParameters& p, const HomographyWords& h,
              const WordLengths& n);

  struct Point {
    bool valid = false;
    Int128 u = 0, v = 0;  ///< coordinate fraction bits
  };
  [[nodiscard]] Point reference(int u, int v) const;
  [[nodiscard]] Point current(int u, int v) const {
    return lens(Int128{u} << coordinate_, Int128{v} << coordinate_);
  }
  [[nodiscard]] std::optional<Address> address(const Point& point) const;
  [[nodiscard]] SampledPoint sampled(const Point& point) const;

 private:
  [[nodiscard]] Int128 sum(std::size_t row, int u, int v) const;
  [[nodiscard]] Int128 normalize(Int128 coordinate, Int128 centre, Int128 f) const;
  [[nodiscard]] Int128 toRaw(Int128 n, Int128 p, Int128 f, Int128 centre) const;
  [[nodiscard]] Point lens(Int128 x, Int128 y) const;

  int linear_, offset_, coordinate_, intrinsic_, normalized_;
  HomographyWords h_;
  FrameParameters p_;
  Int128 fx_, fy_, cx_, cy_, k1_, k2_, k3_, r2_max_;
};

Int128 roundedTo(double value, int fraction_bits) {
  return static_cast<Int128>(std::llround(std::ldexp(value, fraction_bits)));
}

/// value · 2^shift, floored.
Int128 shifted(Int128 value, int shift) { return floorShift(value, -shift); }

GenericWarp::GenericWarp(const GroundView& view, const FrameParameters& p, const HomographyWords& h,
                         const WordLengths& n)
    : linear_(n[ExploredWire::HomographyLinear]),
      offset_(n[ExploredWire::HomographyOffset]),
      coordinate_(n[ExploredWire::Coordinate]),
      intrinsic_(n[ExploredWire::Intrinsic]),
      normalized_(n[ExploredWire::Normalized]),
      h_(h),
      p_(p) {
  const Intrinsics& i = view.camera.intrinsics();
  const Distortion& d = view.camera.distortion();
  const int lens = n[ExploredWire::Lens];
  fx_ = std::max(roundedTo(i.fx, intrinsic_), Int128{1});
  fy_ = std::max(roundedTo(i.fy, intrinsic_), Int128{1});
  cx_ = roundedTo(i.cx, intrinsic_);
  cy_ = roundedTo(i.cy, intrinsic_);
  k1_ = shifted(roundedTo(d.k1, lens), normalized_ - lens);
  k2_ = shifted(roundedTo(d.k2, lens), normalized_ - lens);
  k3_ = shifted(roundedTo(d.k3, lens), normalized_ - lens);
  const double radius = std::ldexp(view.camera.turningRadiusSquared(), normalized_);
  const double highest = std::ldexp(1.0, normalized_ + formats::RadiusSquared::integer_bits) - 1.0;
  r2_max_ = static_cast<Int128>(std::floor(std::min(radius, highest)));
}

Int128 GenericWarp::sum(std::size_t row, int u, int v) const {
  const int fraction = std::max(linear_, offset_);
  const Int128 linear = Int128{h_[3 * row]} * u + Int128{h_[3 * row + 1]} * v;
  return shifted(linear, fraction - linear_) + shifted(h_[3 * row + 2], fraction - offset_);
}

GenericWarp::Point GenericWarp::reference(int u, int v) const {
  const Int128 d = sum(2, u, v);
  if (d <= 0) return {};
  const Int128 x = shifted(sum(0, u, v), coordinate_) / d;
  const Int128 y = shifted(sum(1, u, v), coordinate_) / d;
  const Int128 limit = Int128{1} << (formats::ViewCoordinate::integer_bits - 1 + coordinate_);
  if (x < -limit || x >= limit || y < -limit || y >= limit) return {};
  const bool above = p_.horizon_a * u + p_.horizon_b * v + p_.horizon_c * 16 <= 0;
  if (p_.use_horizon && above) return {};
  return lens(x, y);
}

Int128 GenericWarp::normalize(Int128 coordinate, Int128 centre, Int128 f) const {
  const int fraction = std::max(coordinate_, intrinsic_);
  const Int128 offset =
      shifted(coordinate, fraction - coordinate_) - shifted(centre, fraction - intrinsic_);
  const int shift = normalized_ + intrinsic_ - fraction;
  const Int128 numerator = offset * (Int128{1} << std::max(shift, 0));
  const Int128 q = numerator / (f * (Int128{1} << std::max(-shift, 0)));
  const Int128 limit = Int128{1} << (formats::Normalized::integer_bits - 1 + normalized_);
  return std::min(std::max(q, -limit), limit - 1);
}

Int128 GenericWarp::toRaw(Int128 n, Int128 p, Int128 f, Int128 centre) const {
  const Int128 distorted = (n * p) >> normalized_;
  return shifted(distorted * f, coordinate_ - intrinsic_ - normalized_) +
         shifted(centre, coordinate_ - intrinsic_);
}

GenericWarp::Point GenericWarp::lens(Int128 x, Int128 y) const {
  const Int128 xn = normalize(x, cx_, fx_), yn = normalize(y, cy_, fy_);
  const Int128 r2 = (xn * xn + yn * yn) >> normalized_;
  if (r2 > r2_max_) return {};
  Int128 p = k3_;
  p = ((p * r2) >> normalized_) + k2_;
  p = ((p * r2) >> normalized_) + k1_;
  p = ((p * r2) >> normalized_) + (Int128{1} << normalized_);
  return {true, toRaw(xn, p, fx_, cx_), toRaw(yn, p, fy_, cy_)};
}

std::optional<Address> GenericWarp::address(const Point& point) const {
  if (!point.valid) return std::nullopt;
  const Int128 half = coordinate_ > 0 ? Int128{1} << (coordinate_ - 1) : Int128{0};
  const Int128 u = (point.u + half) >> coordinate_, v = (point.v + half) >> coordinate_;
  if (u < 0 || u >= p_.width || v < 0 || v >= p_.height) return std::nullopt;
  return Address{static_cast<int>(u), static_cast<int>(v)};
}

SampledPoint GenericWarp::sampled(const Point& point) const {
  return {point.valid, std::ldexp(static_cast<double>(point.u), -coordinate_),
          std::ldexp(static_cast<double>(point.v), -coordinate_)};
}

/// Rule 8 with bits kept below the grey level until the sum.
TaggedPixel convolve(const Image<TaggedPixel>& in, int u, int v, int kept) {
  int sum = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const TaggedPixel pixel = in.at(u + du, v + dv);
      const int value = pixel & no_correspondence ? 0 : pixel;
      sum += (value << kept) >> (2 + (du != 0) + (dv != 0));
    }
  }
  return static_cast<TaggedPixel>(sum >> kept);
}

void genericGaussian(const Image<TaggedPixel>& in, Image<TaggedPixel>& out, int kept) {
  for (int v = 0; v < in.height(); ++v) {
    for (int u = 0; u < in.width(); ++u) {
      const bool border = u == 0 || v == 0 || u == in.width() - 1 || v == in.height() - 1;
      const bool invalid = border || (in.at(u, v) & no_correspondence);
      out.at(u, v) = invalid ? no_correspondence : convolve(in, u, v, kept);
    }
  }
}

/// Rule 9 with fraction bits in the class means.
std::optional<std::uint8_t> genericOtsu(const GreyHistogram& bins, int mean_bits) {
  Int128 count = 0, grey = 0, w0 = 0, sub = 0, best = 0;
  for (std::size_t k = 0; k < bins.size(); ++k) {
    count += bins[k];
    grey += static_cast<Int128>(k) * bins[k];
  }
  std::optional<std::uint8_t> threshold;
  for (std::size_t k = 0; k < bins.size(); ++k) {
    w0 += bins[k];
    sub += static_cast<Int128>(k) * bins[k];
    if (w0 == 0 || w0 == count) continue;
    const Int128 step = ((grey - sub) << mean_bits) / (count - w0) - (sub << mean_bits) / w0;
    const Int128 variance = w0 * (count - w0) * step * step;
    if (variance <= best) continue;
    best = variance;
    threshold = static_cast<std::uint8_t>(k);
  }
  return threshold;
}

/// Rules 9 to 15 behind the Gaussian, with the contract's own twins.
void finish(const FrameParameters& p, int mean_bits, Wires& w) {
  Results& r = w.results;
  const auto gaussian = std::as_const(w.gaussian).view();
  histogram(gaussian, r.histogram);
  r.threshold_out =
      genericOtsu(r.histogram, mean_bits).value_or(static_cast<std::uint8_t>(p.threshold_in));
  binarise(gaussian,
           maskThreshold(static_cast<int>(p.threshold_in), static_cast<int>(p.min_threshold)),
           w.mask.view());
  erosion(std::as_const(w.mask).view(), w.eroded.view());
  localize(std::as_const(w.eroded).view(), p, r.bear, r.cor, r.overflow);
  freeSpace(r.bear, p, r.peaks, r.overflow);
  selectContacts(r.cor, r.peaks, static_cast<int>(p.bearing_tolerance), r.selected);
}

}  // namespace

bool WordLengthDatapath::run(const ExplorerInput& input, Wires& wires) {
  SoftwarePart software(parameters_);
  if (software.setCamera(input.view.camera)) return false;
  const FrameSetup setup = software.setup(input.view, input.threshold_in);
  const auto homography = quantiseHomography(
      input.view,
      {lengths_[ExploredWire::HomographyLinear], lengths_[ExploredWire::HomographyOffset]});
  if (setup.status != SetupStatus::Ok || !homography) return false;
  const FrameParameters& p = setup.parameters;
  const GenericWarp warp(input.view, p, homography->words, lengths_);
  wires.prepare(static_cast<int>(p.width), static_cast<int>(p.height));
  wires.results = {};
  sampled_.clear();
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      const auto point = warp.reference(u, v);
      sampled_.push_back(warp.sampled(point));
      const auto r = warp.address(point);
      const auto c = p.undistort_current ? warp.address(warp.current(u, v)) : Address{u, v};
      wires.difference.at(u, v) =
          r && c ? static_cast<TaggedPixel>(
                       std::abs(input.reference.at(r->u, r->v) - input.current.at(c->u, c->v)))
                 : no_correspondence;
    }
  }
  genericGaussian(wires.difference, wires.gaussian, lengths_[ExploredWire::GaussianTerm]);
  finish(p, lengths_[ExploredWire::ClassMean], wires);
  return true;
}

}  // namespace ipm_mapping::fpga
