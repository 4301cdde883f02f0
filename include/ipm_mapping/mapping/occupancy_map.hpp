#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ipm_mapping/mapping/ray_casting.hpp"
#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/map_parameters.hpp"

namespace ipm_mapping {

/// A map of known, free and occupied cells, as nav_msgs/OccupancyGrid has them: row by row from the
/// lower left corner, -1 unknown, 0 free, 100 occupied.
struct TrinaryMap {
  double resolution = 0.05;  ///< side of a cell, metres
  double origin_x = 0.0;     ///< corner of the first cell, metres
  double origin_y = 0.0;
  int width = 0;  ///< cells
  int height = 0;
  std::vector<std::int8_t> cells;
};

/// Where the stored cells lie. Cell (0, 0) of the world has its lower left corner in the origin.
struct MapGeometry {
  Cell first;      ///< world cell of the lower left stored cell
  int width = 0;   ///< cells
  int height = 0;  ///< cells
  double resolution = 0.0;
  std::uint64_t revision = 0;  ///< another number means: rectangles of before no longer fit

  [[nodiscard]] double originX() const { return first.x * resolution; }
  [[nodiscard]] double originY() const { return first.y * resolution; }
  [[nodiscard]] bool empty() const { return width == 0 || height == 0; }
};

/// A rectangle of stored cells, relative to the first one.
struct MapRectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// What a map did not take.
struct MapCounters {
  std::uint64_t frames = 0;             ///< updates that were taken
  std::uint64_t remembered_frames = 0;  ///< seen earlier (age > 0): no new evidence
  std::uint64_t rejected_frames = 0;    ///< pose or camera not finite
  std::uint64_t hits = 0;               ///< contacts that reached a cell
  std::uint64_t rejected = 0;           ///< contacts and bearings that are not finite
  std::uint64_t outside_contacts = 0;   ///< beyond max_side
  std::uint64_t outside_rays = 0;       ///< end beyond max_side; their part inside is used
};

/// Occupancy map on the floor of the odometry frame (the source, §5.4.2, §6.10.2, §7.3). Grows in
/// blocks, around the robot and what it sees; update() allocates only then.
///
/// `mark_once`: the cell of a contact is occupied for good, nothing is ever free (the source).
/// `log_odds`: contacts add `hit` to their cell, floor seen along a bearing takes `miss` from the
/// cells it crosses; within one frame a cell changes once, and a hit wins over misses.
class OccupancyMap {
 public:
  explicit OccupancyMap(const MapParameters& parameters = {});

  /// Takes one frame's contacts and bearings. What is remembered from earlier frames (age > 0), be
  /// it the whole answer or single contacts, is no new evidence and leaves the map alone; so does
  /// the contact of something that moves.
  void update(const Obstacles& obstacles);
  /// Grows the map so that it holds the point (metres, odom); false beyond max_side.
  bool include(const Eigen::Vector2d& point);
  /// Replaces the content, for instance with a map of an earlier run, placed to the nearest cell.
  /// Nothing on success, otherwise what does not fit; then the map stays as it was.
  [[nodiscard]] std::optional<std::string> load(const TrinaryMap& map);
  /// Takes over the content of a map with the same parameters; all of it counts as changed.
  void restore(const OccupancyMap& other);
  /// Forgets everything; the map is empty afterwards.
  void clear();

  [[nodiscard]] const MapGeometry& geometry() const { return geometry_; }
  [[nodiscard]] const MapCounters& counters() const { return counters_; }
  /// Trinary value of stored cell `i` = y * width + x: -1 unknown, 0 free, 100 occupied.
  [[nodiscard]] std::int8_t occupancy(std::size_t i) const;
  /// Probability of being occupied in percent, -1 where nothing was ever seen.
  [[nodiscard]] std::int8_t probability(std::size_t i) const;
  /// Log odds of a world cell; nothing where nothing was ever seen.
  [[nodiscard]] std::optional<float> logOdds(const Cell& world) const;
  /// Copies the trinary values; `map` keeps its memory where it suffices.
  void copyTo(TrinaryMap& map) const;

  /// Rectangle around the cells that changed since the last call; nothing when none did. After a
  /// growth the whole map counts as changed.
  [[nodiscard]] std::optional<MapRectangle> takeChanges();

 private:
  /// World cells, both ends included.
  struct Box {
    Cell low;
    Cell high;
    [[nodiscard]] Box with(const Cell& cell) const;
    [[nodiscard]] bool holds(const Cell& cell) const;
  };
  /// Part of a bearing over which floor was seen, in cells.
  struct Ray {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    bool keeps_end;  ///< the last cell is not free: the obstacle stands there
  };

  [[nodiscard]] std::optional<Cell> contactCell(const Contact& contact, const SE2& T_odom_base);
  [[nodiscard]] std::optional<Ray> rayOf(const Bearing& bearing, const GroundView& view) const;
  void growForRobot(const GroundView& view, std::optional<Box>& needed) const;
  void growForContacts(const Obstacles& obstacles, std::optional<Box>& needed);
  void growForRays(const Obstacles& obstacles, std::optional<Box>& needed);
  bool widen(std::optional<Box>& needed, const Eigen::Vector2d& cells) const;
  void growTo(const std::optional<Box>& needed);
  void hitContacts(const Obstacles& obstacles);
  void missRay(const Ray& ray);
  void applyPending();
  void setLogOdds(const Cell& world, float value);

  [[nodiscard]] std::optional<Box> stored() const;
  [[nodiscard]] std::size_t indexOf(const Cell& world) const;
  [[nodiscard]] float loadedValue(std::int8_t occupancy) const;

  MapParameters parameters_;
  float occupied_from_;  ///< log odds
  float free_up_to_;     ///< log odds
  int block_;            ///< cells
  int max_side_;         ///< cells, a multiple of the block
  MapGeometry geometry_;
  MapCounters counters_;
  std::vector<float> log_odds_;  ///< NaN: never seen
  std::vector<float> pending_;   ///< the present frame's change of each cell; NaN: none
  std::vector<Cell> touched_;    ///< cells with a pending change
  std::optional<Box> changed_;
};

}  // namespace ipm_mapping
