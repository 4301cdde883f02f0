#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/stages/free_space.hpp"

namespace ipm_mapping {

/// Polar coordinates of a bird's-eye view around the mid foot point, which always lies on the
/// principal point: one table a camera (the source, §3.6, §3.8).
class PolarGrid {
 public:
  static constexpr std::uint16_t none = 0xFFFF;

  PolarGrid() = default;
  /// Bins of equal angle from `left` to `right` (radians in base axes, left positive); pixels
  /// outside belong to no bin.
  PolarGrid(const Intrinsics& k, int n_bins, double left, double right);

  [[nodiscard]] int bins() const { return n_bins_; }
  [[nodiscard]] int radii() const { return n_radii_; }
  [[nodiscard]] double angle(double bin) const {
    return left_ + (right_ - left_) * (bin + 0.5) / n_bins_;
  }

  /// Obstacle and seen pixels by bin and by (bin, radius in whole pixels) of one bird's-eye mask.
  struct Counts {
    std::vector<int> bear;                      ///< obstacle pixels of each bin
    std::vector<std::uint16_t> obstacle, seen;  ///< bin * radii() + radius
  };
  void count(GrayView birds_eye_mask, Counts& counts) const;

 private:
  int n_bins_ = 0;
  int n_radii_ = 0;
  double left_ = 0.0;
  double right_ = 0.0;
  std::vector<std::uint16_t> bin_, radius_;  ///< of every pixel, row by row
};

/// A peak's sector: its neighbouring bins down to `share` of its amplitude, both ends included.
struct Sector {
  int first = 0;
  int last = 0;
};
[[nodiscard]] Sector sectorOf(const std::vector<int>& bear, const Peak& peak, double share);

/// First radius (pixels) at which obstacle pixels make up at least `threshold` of the sector's seen
/// pixels of that radius; -1 where there is none (the source, §3.8).
[[nodiscard]] int firstRadius(const PolarGrid::Counts& counts, int n_radii, const Sector& sector,
                              double threshold);
/// Last radius of the unbroken run of seen radii in one bin; first: where that run starts. -1:
/// none.
struct SeenRun {
  int first = -1;
  int last = -1;
};
[[nodiscard]] SeenRun seenRun(const PolarGrid::Counts& counts, int n_radii, int bin);

}  // namespace ipm_mapping
