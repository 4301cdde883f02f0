#include "ipm_mapping/fpga/undistort_warp.hpp"

namespace ipm_mapping::fpga {
namespace {

template <class Format>
Format load(Integer raw) {
  return Format::fromRaw(raw);
}

/// Rule 4: the generator's pixel as a point of the view, u << 6 and v << 6.
ViewPoint viewPoint(int u, int v) {
  using formats::ViewCoordinate;
  constexpr int one = 1 << ViewCoordinate::fraction_bits;
  return {ViewCoordinate::fromRaw(u * one), ViewCoordinate::fromRaw(v * one)};
}

}  // namespace

Homography::Homography(const FrameParameters& p)
    : h11_(load<formats::HomographyLinear>(p.h11)),
      h12_(load<formats::HomographyLinear>(p.h12)),
      h21_(load<formats::HomographyLinear>(p.h21)),
      h22_(load<formats::HomographyLinear>(p.h22)),
      h31_(load<formats::HomographyLinear>(p.h31)),
      h32_(load<formats::HomographyLinear>(p.h32)),
      h13_(load<formats::HomographyOffset>(p.h13)),
      h23_(load<formats::HomographyOffset>(p.h23)),
      h33_(load<formats::HomographyOffset>(p.h33)) {}

Horizon::Horizon(const FrameParameters& p)
    : used_(p.use_horizon != 0),
      a_(load<formats::HomographyLinear>(p.horizon_a)),
      b_(load<formats::HomographyLinear>(p.horizon_b)),
      c_(load<formats::HomographyOffset>(p.horizon_c)) {}

bool Horizon::above(formats::Generated u, formats::Generated v) const {
  return used_ && (a_ * u + b_ * v + c_).raw() <= 0;
}

Lens::Lens(const FrameParameters& p)
    : fx_(load<formats::CameraIntrinsic>(p.fx)),
      fy_(load<formats::CameraIntrinsic>(p.fy)),
      cx_(load<formats::CameraIntrinsic>(p.cx)),
      cy_(load<formats::CameraIntrinsic>(p.cy)),
      k1_(load<formats::LensCoefficient>(p.k1)),
      k2_(load<formats::LensCoefficient>(p.k2)),
      k3_(load<formats::LensCoefficient>(p.k3)),
      r2_max_(load<formats::RadiusSquared>(p.r2_max)) {}

std::optional<Lens::RawPoint> Lens::distort(const ViewPoint& point, std::uint64_t& xn_count,
                                            std::uint64_t& yn_count) const {
  using formats::Normalized;
  constexpr int fraction = Normalized::fraction_bits;
  const auto xn = saturate<Normalized>(divide<fraction>(point.x - cx_, fx_), xn_count);
  const auto yn = saturate<Normalized>(divide<fraction>(point.y - cy_, fy_), yn_count);
  std::uint64_t never = 0;  // 20-bit operands: at most 2^23
  const auto r2 = saturate<formats::RadiusSquared>(xn * xn + yn * yn, never);
  if (r2.raw() > r2_max_.raw()) return std::nullopt;
  const auto p2 = dropFraction<fraction>(widen<Fixed<19, 3>>(k3_) * r2) + k2_;
  const auto p1 = dropFraction<fraction>(p2 * r2) + k1_;
  const auto p = dropFraction<fraction>(p1 * r2) + Unsigned<1>::fromRaw(1);
  const auto toRaw = [&p](Normalized n, formats::CameraIntrinsic f, formats::CameraIntrinsic c) {
    return dropFraction<6>(dropFraction<fraction>(n * p) * f) + c;
  };
  return RawPoint{toRaw(xn, fx_, cx_), toRaw(yn, fy_, cy_)};
}

AddressGenerator::AddressGenerator(const FrameParameters& p)
    : width_(static_cast<int>(p.width)),
      height_(static_cast<int>(p.height)),
      memory_rows_(static_cast<int>(p.memory_rows)) {}

std::optional<Address> AddressGenerator::nearest(const Lens::RawPoint& point) const {
  const auto half = Fixed<6, 0, Sign::Unsigned>::fromRaw(32);
  const auto u = fit<formats::Column>(dropFraction<0>(point.u + half));
  const auto v = fit<formats::Row>(dropFraction<0>(point.v + half));
  if (!u || !v || u->raw() >= width_ || v->raw() >= height_) return std::nullopt;
  return Address{static_cast<int>(u->raw()), static_cast<int>(v->raw())};
}

formats::Address AddressGenerator::memory(int offset, const Address& pixel) const {
  return formats::Address::fromRaw((offset + pixel.v) % memory_rows_ * width_ + pixel.u);
}

bool AddressGenerator::readsNearWrite(int v, const Address& pixel) const {
  const int overwritten = v - (memory_rows_ - height_);
  return overwritten >= 0 && pixel.v - overwritten < read_write_margin;
}

UndistortWarp::UndistortWarp(const FrameParameters& p)
    : homography_(p),
      horizon_(p),
      lens_(p),
      address_(p),
      paper_order_(p.paper_order != 0),
      undistort_current_(p.undistort_current != 0) {}

std::optional<ViewPoint> UndistortWarp::inReferenceView(int u, int v, OverflowCounters&) const {
  const auto column = formats::Generated::fromRaw(u);
  const auto row = formats::Generated::fromRaw(v);
  const auto point = homography_.project(column, row);
  if (!point || horizon_.above(column, row)) return std::nullopt;
  return point;
}

std::optional<Lens::RawPoint> UndistortWarp::inReferenceFramePaperOrder(
    int u, int v, OverflowCounters& counters) const {
  const auto bent = lens_.distort(viewPoint(u, v), counters[Wire::Xn], counters[Wire::Yn]);
  if (!bent) return std::nullopt;
  const auto x = fit<formats::ViewCoordinate>(bent->u);
  const auto y = fit<formats::ViewCoordinate>(bent->v);
  if (!x || !y) return std::nullopt;
  if (horizon_.above(formats::Generated::fromRaw(u), formats::Generated::fromRaw(v))) {
    return std::nullopt;
  }
  const auto point = homography_.project(*x, *y);
  if (!point) return std::nullopt;
  return Lens::RawPoint{widen<Lens::Distorted>(point->x), widen<Lens::Distorted>(point->y)};
}

std::optional<Address> UndistortWarp::reference(int u, int v, OverflowCounters& counters) const {
  std::optional<Lens::RawPoint> raw;
  if (paper_order_) {
    raw = inReferenceFramePaperOrder(u, v, counters);
  } else if (const auto point = inReferenceView(u, v, counters)) {
    raw = lens_.distort(*point, counters[Wire::Xn], counters[Wire::Yn]);
  }
  if (!raw) return std::nullopt;
  const auto pixel = address_.nearest(*raw);
  if (pixel && address_.readsNearWrite(v, *pixel)) ++counters[Wire::ReadWrite];
  return pixel;
}

std::optional<Address> UndistortWarp::current(int u, int v, OverflowCounters& counters) const {
  if (!undistort_current_) return Address{u, v};
  const auto raw =
      lens_.distort(viewPoint(u, v), counters[Wire::XnCurrent], counters[Wire::YnCurrent]);
  return raw ? address_.nearest(*raw) : std::nullopt;
}

}  // namespace ipm_mapping::fpga
