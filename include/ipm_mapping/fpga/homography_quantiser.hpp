#pragma once
// Software part of rules 3 and 4: from double-precision geometry to coefficients (§6.2.4).

#include <array>
#include <optional>
#include <string>

#include "ipm_mapping/fpga/frame_parameters.hpp"
#include "ipm_mapping/geometry/ground_view.hpp"

namespace ipm_mapping::fpga {

/// Nine register values, row-major.
using HomographyWords = std::array<std::int32_t, 9>;

struct QuantisedHomography {
  HomographyWords words{};
  double worst_error = 0.0;  ///< px, at the worst point of the grid
  double scale = 0.0;        ///< of the matrix before rounding
  int steps = 0;             ///< of the polish
};

/// Fraction bits of the coefficients; the integer bits are those of rule 3. The word-length
/// explorer turns them, the hardware has the defaults.
struct CoefficientFormat {
  int linear = formats::HomographyLinear::fraction_bits;
  int offset = formats::HomographyOffset::fraction_bits;

  /// Steps per unit of coefficient i, row-major.
  [[nodiscard]] double unit(std::size_t i) const;
  /// Whether a rounded coefficient fits its register.
  [[nodiscard]] bool fits(std::size_t i, double rounded) const;
};

/// Points of the undistorted current view on which quantisation errors are measured: floor in
/// both views, seen by both raw frames.
class ErrorGrid {
 public:
  static constexpr int columns = 17, rows = 13;
  static constexpr int capacity = columns * rows;

  ErrorGrid(const GroundView& view, const Eigen::Matrix3d& G, CoefficientFormat format = {});

  [[nodiscard]] int size() const { return size_; }
  /// Greatest distance in units of 2^-20 px; nothing when it reaches `limit` or D <= 0 somewhere.
  /// Remembers the worst point, to look at it first the next time.
  [[nodiscard]] std::optional<std::int64_t> error(const HomographyWords& words, std::int64_t limit);

 private:
  /// Points are looked at in groups, so that a bad candidate is dropped early.
  static constexpr std::size_t group = 16;
  static constexpr std::size_t padded = (capacity + group - 1) / group * group;

  void add(double u, double v, const Eigen::Vector2d& target);
  void pad();
  void moveToFront(std::size_t worst);

  std::array<double, padded> u_{}, v_{};  ///< integers
  std::array<double, padded> x_{}, y_{};  ///< where G takes them
  int size_ = 0;
  CoefficientFormat format_;
};

/// Scales the matrix, rounds it and polishes the best candidates. Nothing when no grid point or no
/// scale is left: the frame is skipped as homography_unusable.
[[nodiscard]] std::optional<QuantisedHomography> quantiseHomography(const GroundView& view,
                                                                    CoefficientFormat format = {});

/// The same with one rounding at the largest power of two that fits: what a designer would do
/// first, kept to show what the search gains.
[[nodiscard]] std::optional<QuantisedHomography> quantiseAtPowerOfTwo(const GroundView& view);

/// horizon_a, horizon_b, horizon_c.
[[nodiscard]] std::array<std::int32_t, 3> quantiseHorizon(const GroundView& view);

/// Writes fx ... k3 and r2_max. Says which value does not fit its register, or nothing.
[[nodiscard]] std::optional<CalibrationError> quantiseCamera(const CameraModel& camera,
                                                             FrameParameters& p);

}  // namespace ipm_mapping::fpga
