#pragma once

#include <cmath>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// How the robot's attitude in one frame differs from that in another, radians: no robot is quite
/// rigid, and no floor quite even. Axes of the base: a positive pitch looks down.
struct Sway {
  double pitch = 0.0, roll = 0.0;

  [[nodiscard]] double size() const { return std::hypot(pitch, roll); }
  /// How much farther down what is straight ahead at an azimuth is looked at.
  [[nodiscard]] double at(double azimuth) const {
    return pitch * std::cos(azimuth) - roll * std::sin(azimuth);
  }
};

/// Takes a rectified image to another attitude of the camera. A sway (p, q) moves what is seen at
/// azimuth a and slope r by
///   d ln r = -(1 + r^2) / r (p cos a - q sin a),   d a = -r (p sin a + q cos a).
class SwayCorrection {
 public:
  void configure(const PolarGrid& grid, const std::vector<RowRange>& rows);

  /// `image` was taken with `sway`; `out`, of the grid's size, is how it looks without. `seen`: the
  /// rows of each line for which the image has what they show; beside them `out` is made up.
  void remove(const Sway& sway, const Image<std::uint8_t>& image, Image<std::uint8_t>& out,
              std::vector<RowRange>& seen) const;

 private:
  [[nodiscard]] RowRange reached(RowRange moved, float along) const;
  static float across(float lines, float r_most);

  PolarGrid grid_;
  std::vector<RowRange> rows_;      // that a line shares with those beside it
  std::vector<float> cos_, sin_;    // of the azimuths
  std::vector<float> r_, stretch_;  // of the rows: r and (1 + r^2) / r
};

}  // namespace ipm_mapping::sweep
