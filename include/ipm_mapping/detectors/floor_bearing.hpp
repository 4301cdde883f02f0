#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "ipm_mapping/geometry/ground_homography.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/obstacles.hpp"

namespace ipm_mapping {

/// The floor of one view in base: points for pixels, angles and distances from the camera's foot.
struct FloorOfView {
  GroundProjection projection;
  Eigen::Vector2d foot;

  explicit FloorOfView(const GroundView& view)
      : projection(view.currentFloor()), foot(view.cameraFoot()) {}
  [[nodiscard]] std::optional<Eigen::Vector2d> at(int u, int v) const {
    return projection.floor({u, v});
  }
  [[nodiscard]] float angle(const Eigen::Vector2d& p) const {
    return static_cast<float>(std::atan2(p.y() - foot.y(), p.x() - foot.x()));
  }
};

/// What ends a line's free floor: a contact (Occupied) or a blob whose foot is not known (Blocked).
struct LineStop {
  int u = 0;
  int v = 0;
  BearingState state = BearingState::Occupied;
};

/// One line of pixels on the mask.
struct LineOnMask {
  const std::int16_t* columns;  ///< one a row of the mask; PolarBeam::outside where not in it
  const std::uint8_t* values;   ///< of these pixels: mask::floor, unseen or obstacle
  int height;                   ///< rows
};

/// What a line says about its bearing: free up to where the unbroken run of seen floor ends within
/// `max_range` (metres from base), or stopped before; unknown where less than `min_floor_share` of
/// the floor rows within range were seen.
[[nodiscard]] Bearing floorBearing(const LineOnMask& line, const FloorOfView& floor,
                                   double max_range, double min_floor_share, float density,
                                   const std::optional<LineStop>& stop);

/// Lowest row of the lowest run of at least `min_pixels` obstacle pixels on the line; -1: none.
[[nodiscard]] int lowestRun(const LineOnMask& line, int min_pixels);

}  // namespace ipm_mapping
