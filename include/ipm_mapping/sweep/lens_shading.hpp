#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "ipm_mapping/parameters/calibration_parameters.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"

namespace ipm_mapping::sweep {

/// Floor that two frames see, their motion being known: `count` grey levels and where they are
/// seen.
struct FloorSamples {
  const float* current = nullptr;
  const float* before = nullptr;  ///< of the reference, in the current frame's brightness
  const int* row = nullptr;       ///< in the current frame
  const int* line = nullptr;
  const float* reference_row = nullptr;
  const float* reference_line = nullptr;
  int count = 0;
  double sigma = 1.0;  ///< robust spread of current - before, grey levels
};

/// Lenses darken towards the corners of the image,
///   seen = true (1 - shading rho^2),   rho^2 = CylindricalRectification::squaredRadius(),
/// so that a surface grows darker on its way to the edge of the view. The floor takes that way all
/// the time: what its grey level I changes by from the reference to the current frame is fitted,
/// with Tukey weights, as
///   e = g I + o + I (a d(ln r) + b d r) - shading I d(rho^2).
/// Gain g and offset o are what exposure has left over. a and b stand for whatever depends on how
/// steeply the floor is looked at, gloss above all: what tells the lens from them is that the ends
/// of a row darken and its middle does not. Every pair counts as at least sd_shading_pair off, and
/// old ones fade. No lens brightens the corners: what says so is gloss.
class LensShading {
 public:
  void configure(const CalibrationParameters& parameters) { parameters_ = parameters; }
  /// No pair has more samples than this.
  void reserve(std::size_t samples) { rows_.reserve(samples); }
  /// Another camera.
  void forget();
  /// Takes over what another one has learnt.
  void adopt(const LensShading& other);

  /// Learns from a pair of frames that were rectified alike.
  void learn(const CylindricalRectification& rectification, const FloorSamples& floor);
  /// Between none, or what is stated if that is less, and max_shading.
  [[nodiscard]] double estimate() const;
  [[nodiscard]] double sigma() const;
  [[nodiscard]] int pairs() const { return pairs_; }
  /// Is it surely and usefully another one than what is in force?
  [[nodiscard]] bool differs(double in_force) const;

 private:
  /// One sample: its change, and how that moves with the unknowns.
  struct Row {
    std::array<double, 5> slopes;
    double change;
  };
  /// Of one pair: shading, gain, offset, a and b.
  struct Fit {
    static constexpr int unknowns = 5, others = unknowns - 1;
    using Unknowns = Eigen::Matrix<double, unknowns, 1>;
    Eigen::Matrix<double, unknowns, unknowns> A;
    Unknowns b, solution = Unknowns::Zero();
    void add(const std::vector<Row>& rows, double limit);
  };
  void fillRows(const CylindricalRectification& rectification, const FloorSamples& floor);
  [[nodiscard]] double priorInformation() const;

  CalibrationParameters parameters_;
  double sum_ = 0.0, information_ = 0.0;  // of the pairs
  int pairs_ = 0;
  std::vector<Row> rows_;
};

}  // namespace ipm_mapping::sweep
