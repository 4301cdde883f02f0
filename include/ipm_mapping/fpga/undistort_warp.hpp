#pragma once
// Twin of the fused undistortion and warp: coordinates generator, homography, lens, address
// (the source, §6.2; rules 2-6).

#include <optional>

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/fpga/frame_parameters.hpp"
#include "ipm_mapping/fpga/overflow.hpp"

namespace ipm_mapping::fpga {

/// A pixel of a raw frame (rule 5).
struct Address {
  int u = 0;
  int v = 0;
};

/// A point between homography and lens (rule 2).
struct ViewPoint {
  formats::ViewCoordinate x, y;
};

/// Rule 3: the 9 coefficients and the division.
class Homography {
 public:
  explicit Homography(const FrameParameters& p);

  /// Point of the reference view, from integers (rule 3) or from 12.6 coordinates (rule 4,
  /// paper_order): the operands' fraction bits decide the shifts.
  template <class Coordinate>
  [[nodiscard]] std::optional<ViewPoint> project(Coordinate u, Coordinate v) const {
    const auto denominator = h31_ * u + h32_ * v + h33_;
    if (denominator.raw() <= 0) return std::nullopt;
    const auto x = fit<formats::ViewCoordinate>(
        divide<coordinate_fraction>(h11_ * u + h12_ * v + h13_, denominator));
    const auto y = fit<formats::ViewCoordinate>(
        divide<coordinate_fraction>(h21_ * u + h22_ * v + h23_, denominator));
    if (!x || !y) return std::nullopt;
    return ViewPoint{*x, *y};
  }

 private:
  static constexpr int coordinate_fraction = formats::ViewCoordinate::fraction_bits;
  formats::HomographyLinear h11_, h12_, h21_, h22_, h31_, h32_;
  formats::HomographyOffset h13_, h23_, h33_;
};

/// Rule 3: whether a pixel of the generator lies below the horizon of the current view.
class Horizon {
 public:
  explicit Horizon(const FrameParameters& p);
  [[nodiscard]] bool above(formats::Generated u, formats::Generated v) const;

 private:
  bool used_;
  formats::HomographyLinear a_, b_;
  formats::HomographyOffset c_;
};

/// Rule 4: from the pinhole view to the raw frame.
class Lens {
 public:
  explicit Lens(const FrameParameters& p);

  /// The exact coordinate after distortion: 6 fraction bits, as wide as the operators of
  /// distort() make it.
  using Distorted = Fixed<51, 45>;
  struct RawPoint {
    Distorted u, v;
  };

  /// Nothing beyond the turning radius. Saturations are counted on the two wires given.
  [[nodiscard]] std::optional<RawPoint> distort(const ViewPoint& point, std::uint64_t& xn_count,
                                                std::uint64_t& yn_count) const;

 private:
  formats::CameraIntrinsic fx_, fy_, cx_, cy_;
  formats::LensCoefficient k1_, k2_, k3_;
  formats::RadiusSquared r2_max_;
};

/// Rule 5: nearest pixel of a raw frame; nothing outside it.
class AddressGenerator {
 public:
  explicit AddressGenerator(const FrameParameters& p);

  [[nodiscard]] std::optional<Address> nearest(const Lens::RawPoint& point) const;
  /// Position in the ring memory whose first row of I_n is `offset`.
  [[nodiscard]] formats::Address memory(int offset, const Address& pixel) const;
  /// Whether the row that I_n+1 is being written to at generator row v comes within 50 rows of
  /// the row being read.
  [[nodiscard]] bool readsNearWrite(int v, const Address& pixel) const;

 private:
  int width_, height_, memory_rows_;
};

/// Both address streams of one frame.
class UndistortWarp {
 public:
  explicit UndistortWarp(const FrameParameters& p);

  /// Pixel of I_n that corresponds to (u, v) of the undistorted current view (rules 3-5).
  [[nodiscard]] std::optional<Address> reference(int u, int v, OverflowCounters& counters) const;
  /// Raw pixel of I_n+1 that (u, v) shows (rule 6).
  [[nodiscard]] std::optional<Address> current(int u, int v, OverflowCounters& counters) const;

 private:
  [[nodiscard]] std::optional<ViewPoint> inReferenceView(int u, int v,
                                                         OverflowCounters& counters) const;
  [[nodiscard]] std::optional<Lens::RawPoint> inReferenceFramePaperOrder(
      int u, int v, OverflowCounters& counters) const;

  Homography homography_;
  Horizon horizon_;
  Lens lens_;
  AddressGenerator address_;
  bool paper_order_, undistort_current_;
};

}  // namespace ipm_mapping::fpga
