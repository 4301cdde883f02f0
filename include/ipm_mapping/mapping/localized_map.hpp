#pragma once

#include <optional>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/map_parameters.hpp"

namespace ipm_mapping {

/// Occupancy map in a frame in which a localiser places the odometry's frame. Odometry leads from
/// one frame to the next, without a jump; where the localiser puts them may change at once, and
/// then the frames since the correction before it are placed anew, as `MapCorrection` says, so that
/// one obstacle does not stand in the map twice.
///
/// With T_map_odom before and D * T_map_odom after, a frame that was seen at the pose T_map_base is
/// moved to the way w between T_map_base and D * T_map_base: w = 1 for `follow`; for `spread` the
/// share of the way driven since the last correction; nothing is moved for `keep`, nor when the
/// correction only makes up for odometry that began anew elsewhere.
class LocalizedMap {
 public:
  /// `map` outlives this; `frames` are remembered at most, older ones stay where they are.
  LocalizedMap(OccupancyMap& map, MapCorrection correction, int frames);

  /// Takes one frame with the odometry's frame where the localiser has it now. True when that is
  /// another place than for the frame before, by more than a few millimetres or milliradians.
  bool update(const Obstacles& answer, const SE2& T_map_odom);
  /// The map's content came from elsewhere, or is gone: no frame of before moves any more.
  void forget();
  /// Empties the map.
  void clear();

 private:
  struct Remembered {
    Obstacles answer;  ///< its T_odom_base is the pose in the map
    double way = 0.0;  ///< metres driven since the last correction
  };

  [[nodiscard]] bool odometryBeganAnew(const SE2& T_odom_base, const SE2& T_map_odom) const;
  void remember();
  void replace(const SE2& D);

  OccupancyMap& map_;
  OccupancyMap base_;  ///< the map of all that is no longer remembered
  MapCorrection correction_;
  std::vector<Remembered> ring_;
  std::size_t first_ = 0, size_ = 0;
  double way_ = 0.0;
  std::optional<SE2> T_map_odom_;   ///< of the frame before
  std::optional<SE2> T_odom_base_;  ///< the same; nothing at the beginning of a stretch
  Obstacles placed_;                ///< the present frame, its pose in the map
};

}  // namespace ipm_mapping
