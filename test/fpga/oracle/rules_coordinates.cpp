// Rules 1 to 6: coordinates and addresses.

#include <stdexcept>

#include "rules.hpp"

namespace oracle {
namespace {

static_assert((Int{-3} >> 1) == -2, "rule 1: >> goes to minus infinity");
static_assert(Int{-3} / 2 == -1, "rule 1: / truncates toward 0");

constexpr Width signed12_6{18, true};
constexpr Width normalised{20, true};
constexpr Width radius{24, false};

/// Rule 1: intermediates are exact int64.
Int exact(Int value) {
  if (!Width{64, true}.holds(value)) throw std::overflow_error("an intermediate leaves int64");
  return value;
}

/// Rule 1: << is multiplication by 2^n, also of negative values.
Int shiftLeft(Int value, int n) { return exact(value * (Int{1} << n)); }

Point invalid() { return Point{false, 0, 0}; }

/// Rule 4: the polynomial in 16 fraction bits.
Int radialFactor(const Params& p, Int r2) {
  const Int k1 = shiftLeft(p.k1, 5), k2 = shiftLeft(p.k2, 5), k3 = shiftLeft(p.k3, 5);
  Int f = k3;
  f = (exact(f * r2) >> 16) + k2;
  f = (exact(f * r2) >> 16) + k1;
  f = (exact(f * r2) >> 16) + 65536;
  return exact(f);
}

}  // namespace

Int writeWire(Int value, Width width, int64_t& counter) {
  if (width.holds(value)) return value;
  ++counter;
  return value < 0 ? width.lowest() : width.highest();
}

/// Rule 3, first paragraph; `fraction_bits` of the input are 0, or 6 in the order of the source.
Point homography(const Params& p, const Point& in, int fraction_bits, Wires& w) {
  const int align = 4 + fraction_bits;
  const Int nx = exact(p.h11 * in.x + p.h12 * in.y + shiftLeft(p.h13, align));
  const Int ny = exact(p.h21 * in.x + p.h22 * in.y + shiftLeft(p.h23, align));
  const Int d = exact(p.h31 * in.x + p.h32 * in.y + shiftLeft(p.h33, align));
  if (d <= 0) {
    ++w.events[DepthNotPositive];
    return invalid();
  }
  const Int x = shiftLeft(nx, 6) / d;
  const Int y = shiftLeft(ny, 6) / d;
  if (signed12_6.holds(x) && signed12_6.holds(y)) return Point{true, x, y};
  ++w.events[LeavesTwelveSix];
  return invalid();
}

/// Rule 3, horizon: on the generator's integers.
bool belowHorizon(const Params& p, int u, int v) {
  if (p.use_horizon == 0) return true;
  return Int{p.horizon_a} * u + Int{p.horizon_b} * v + shiftLeft(p.horizon_c, 4) > 0;
}

/// Rule 4.
Point distort(const Params& p, const Point& in, int64_t& xn_counter, int64_t& yn_counter,
              Wires& w) {
  if (!in.valid) return invalid();
  const Int xn = writeWire(shiftLeft(in.x - p.cx, 16) / p.fx, normalised, xn_counter);
  const Int yn = writeWire(shiftLeft(in.y - p.cy, 16) / p.fy, normalised, yn_counter);
  const Int r2 = exact(xn * xn + yn * yn) >> 16;
  if (!radius.holds(r2)) throw std::overflow_error("r2 leaves its 24 bits");
  if (r2 > p.r2_max) {
    ++w.events[BeyondTurningRadius];
    return invalid();
  }
  const Int factor = radialFactor(p, r2);
  const Int xd = exact(xn * factor) >> 16;
  const Int yd = exact(yn * factor) >> 16;
  return Point{true, (exact(xd * p.fx) >> 16) + p.cx, (exact(yd * p.fy) >> 16) + p.cy};
}

/// Rule 5, first sentence.
Address address(const Params& p, const Point& distorted) {
  if (!distorted.valid) return Address{};
  const Int ui = (distorted.x + 32) >> 6;
  const Int vi = (distorted.y + 32) >> 6;
  if (ui < 0 || ui >= p.width || vi < 0 || vi >= p.height) return Address{};
  return Address{true, static_cast<int>(ui), static_cast<int>(vi)};
}

namespace {

/// Rules 3, 4, 5 in the order of the contract.
Address homographyFirst(const Params& p, int u, int v, Wires& w) {
  Point point = homography(p, Point{true, u, v}, 0, w);
  if (point.valid && !belowHorizon(p, u, v)) {
    ++w.events[AboveHorizon];
    point = invalid();
  }
  return address(p, distort(p, point, w.overflow[Xn], w.overflow[Yn], w));
}

/// Rule 4, paper_order.
Address distortionFirst(const Params& p, int u, int v, Wires& w) {
  const Point generated{true, shiftLeft(u, 6), shiftLeft(v, 6)};
  const Point distorted = distort(p, generated, w.overflow[Xn], w.overflow[Yn], w);
  if (!distorted.valid) return Address{};
  if (!signed12_6.holds(distorted.x) || !signed12_6.holds(distorted.y)) {
    ++w.events[LeavesTwelveSix];
    return Address{};
  }
  if (!belowHorizon(p, u, v)) {
    ++w.events[AboveHorizon];
    return Address{};
  }
  return address(p, homography(p, distorted, 6, w));
}

}  // namespace

AddressImage referenceAddresses(const Params& p, Wires& w) {
  AddressImage image;
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      image.push_back(p.paper_order == 1 ? distortionFirst(p, u, v, w)
                                         : homographyFirst(p, u, v, w));
      if (!image.back().valid) ++w.events[OutsideReference];
    }
  }
  return image;
}

/// Rule 6.
AddressImage currentAddresses(const Params& p, Wires& w) {
  AddressImage image;
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      if (p.undistort_current == 0) {
        image.push_back(Address{true, u, v});
        continue;
      }
      const Point generated{true, shiftLeft(u, 6), shiftLeft(v, 6)};
      image.push_back(
          address(p, distort(p, generated, w.overflow[XnCurrent], w.overflow[YnCurrent], w)));
      if (!image.back().valid) ++w.events[NoCurrent];
    }
  }
  return image;
}

/// Rule 5, counter read_write: the reference's row against the row being written.
void countReadWrite(const Params& p, const AddressImage& reference, Wires& w) {
  const int spare = p.memory_rows - p.height;
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      const Address& from = reference[static_cast<size_t>(v * p.width + u)];
      if (from.valid && v >= spare && from.v - (v - spare) < 50) ++w.overflow[ReadWrite];
    }
  }
}

}  // namespace oracle
