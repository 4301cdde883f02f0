#include "ipm_mapping/mapping/occupancy_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

constexpr float never_seen = std::numeric_limits<float>::quiet_NaN();
constexpr float no_change = std::numeric_limits<float>::quiet_NaN();
constexpr float for_good = std::numeric_limits<float>::infinity();
// Farther out, a cell's index would not be safe to compute with as an int.
constexpr double farthest_cell = 1e9;

float logOddsOf(double probability) {
  return static_cast<float>(std::log(probability / (1.0 - probability)));
}

int floorToMultiple(int value, int step) {
  const int rest = value % step;
  return value - (rest < 0 ? rest + step : rest);
}

bool usable(const Eigen::Vector2d& cells) {
  return std::abs(cells.x()) < farthest_cell && std::abs(cells.y()) < farthest_cell;
}

bool finite(const GroundView& view) {
  return view.T_odom_base.finite() && view.cameraFoot().allFinite();
}

bool finite(const Bearing& bearing) {
  return std::isfinite(bearing.angle) && std::isfinite(bearing.range) &&
         std::isfinite(bearing.near);
}

/// A contact that is known less exactly than to a cell says less about that cell.
double certainty(const Contact& contact, double resolution) {
  if (!(contact.range_sigma > 0.0F)) return 1.0;
  return std::min(1.0, resolution / (2.0 * static_cast<double>(contact.range_sigma)));
}

/// A map keeps nothing of what goes away again.
bool fresh(const Contact& contact) { return !(contact.age > 0.0F) && !contact.moving; }

}  // namespace

OccupancyMap::Box OccupancyMap::Box::with(const Cell& cell) const {
  return {{std::min(low.x, cell.x), std::min(low.y, cell.y)},
          {std::max(high.x, cell.x), std::max(high.y, cell.y)}};
}

bool OccupancyMap::Box::holds(const Cell& cell) const {
  return cell.x >= low.x && cell.y >= low.y && cell.x <= high.x && cell.y <= high.y;
}

OccupancyMap::OccupancyMap(const MapParameters& parameters)
    : parameters_(parameters),
      occupied_from_(logOddsOf(parameters.occupied_above)),
      free_up_to_(logOddsOf(parameters.free_below)),
      block_(std::min(parameters.block, parameters.max_side)) {
  validateFields("map", parameters);
  max_side_ = floorToMultiple(parameters.max_side, block_);
  geometry_.resolution = parameters.resolution;
}

void OccupancyMap::update(const Obstacles& obstacles) {
  if (obstacles.age > 0.0F) {
    ++counters_.remembered_frames;
    return;
  }
  if (!finite(obstacles.view)) {
    ++counters_.rejected_frames;
    return;
  }
  ++counters_.frames;
  const bool casts = parameters_.update == MapUpdate::LogOdds;
  std::optional<Box> needed = stored();
  growForRobot(obstacles.view, needed);
  growForContacts(obstacles, needed);
  if (casts) growForRays(obstacles, needed);
  growTo(needed);
  hitContacts(obstacles);
  for (std::size_t i = 0; casts && i < obstacles.bearings.size(); ++i)
    if (const auto ray = rayOf(obstacles.bearings[i], obstacles.view)) missRay(*ray);
  applyPending();
}

bool OccupancyMap::include(const Eigen::Vector2d& point) {
  std::optional<Box> needed = stored();
  if (!widen(needed, point / parameters_.resolution)) return false;
  growTo(needed);
  return true;
}

void OccupancyMap::restore(const OccupancyMap& other) {
  const std::uint64_t revision = geometry_.revision + 1;
  geometry_ = other.geometry_;
  geometry_.revision = revision;
  log_odds_ = other.log_odds_;
  pending_.assign(log_odds_.size(), no_change);
  changed_ = stored();
}

void OccupancyMap::clear() {
  geometry_.width = geometry_.height = 0;
  geometry_.first = {};
  ++geometry_.revision;
  log_odds_.clear();
  pending_.clear();
  changed_.reset();
}

// --- what a frame says -------------------------------------------------------

/// Nothing where the contact is not finite or lies where no cell has an index.
std::optional<Cell> OccupancyMap::contactCell(const Contact& contact, const SE2& T_odom_base) {
  const Eigen::Vector2d cells =
      T_odom_base * Eigen::Vector2d(contact.p_base.cast<double>()) / parameters_.resolution;
  if (!usable(cells)) return std::nullopt;
  return cellOf(cells);
}

/// Nothing where no floor was seen. No ray is longer than the map can be.
std::optional<OccupancyMap::Ray> OccupancyMap::rayOf(const Bearing& bearing,
                                                     const GroundView& view) const {
  if (bearing.state == BearingState::Unknown || !finite(bearing)) return std::nullopt;
  const double near = std::max(0.0, static_cast<double>(bearing.near));
  const double longest = max_side_ * parameters_.resolution;
  const double range = std::min(static_cast<double>(bearing.range), longest);
  if (near > range) return std::nullopt;
  const double heading = view.T_odom_base.theta + static_cast<double>(bearing.angle);
  const Eigen::Vector2d direction(std::cos(heading), std::sin(heading));
  const Eigen::Vector2d foot = view.T_odom_base * view.cameraFoot();
  const Ray ray{(foot + near * direction) / parameters_.resolution,
                (foot + range * direction) / parameters_.resolution,
                bearing.state == BearingState::Occupied && range < longest};
  if (!usable(ray.from) || !usable(ray.to)) return std::nullopt;
  return ray;
}

void OccupancyMap::hitContacts(const Obstacles& obstacles) {
  const std::optional<Box> box = stored();
  for (const Contact& contact : obstacles.contacts) {
    if (!fresh(contact)) continue;
    const auto cell = contactCell(contact, obstacles.view.T_odom_base);
    if (!cell || !box || !box->holds(*cell)) continue;
    float& pending = pending_[indexOf(*cell)];
    const auto gain =
        static_cast<float>(parameters_.hit * certainty(contact, parameters_.resolution));
    if (std::isnan(pending)) touched_.push_back(*cell);
    pending = std::isnan(pending) ? gain : std::max(pending, gain);
    ++counters_.hits;
  }
}

void OccupancyMap::missRay(const Ray& ray) {
  const std::optional<Box> box = stored();
  const Cell end = cellOf(ray.to);
  forEachCellOnSegment(ray.from, ray.to, [&](const Cell& cell) {
    if (!box || !box->holds(cell) || (ray.keeps_end && cell == end)) return;
    float& pending = pending_[indexOf(cell)];
    if (!std::isnan(pending)) return;
    pending = static_cast<float>(-parameters_.miss);
    touched_.push_back(cell);
  });
}

void OccupancyMap::applyPending() {
  const auto clamp = static_cast<float>(parameters_.clamp);
  for (const Cell& cell : touched_) {
    const std::size_t i = indexOf(cell);
    const float before = std::isnan(log_odds_[i]) ? 0.0F : log_odds_[i];
    const float after = std::clamp(before + pending_[i], -clamp, clamp);
    setLogOdds(cell, parameters_.update == MapUpdate::MarkOnce ? for_good : after);
    pending_[i] = no_change;
  }
  touched_.clear();
}

void OccupancyMap::setLogOdds(const Cell& world, float value) {
  float& stored_value = log_odds_[indexOf(world)];
  if (stored_value == value) return;
  stored_value = value;
  changed_ = changed_ ? changed_->with(world) : Box{world, world};
}

// --- growth --------------------------------------------------------------------

/// A planner has to find the robot in the map, also where it has not seen the floor under itself.
void OccupancyMap::growForRobot(const GroundView& view, std::optional<Box>& needed) const {
  const Eigen::Vector2d place(view.T_odom_base.x, view.T_odom_base.y);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(parameters_.margin);
  (void)widen(needed, (place - margin) / parameters_.resolution);
  (void)widen(needed, (place + margin) / parameters_.resolution);
}

void OccupancyMap::growForContacts(const Obstacles& obstacles, std::optional<Box>& needed) {
  for (const Contact& contact : obstacles.contacts) {
    if (!fresh(contact)) continue;
    const Eigen::Vector2d point =
        obstacles.view.T_odom_base * Eigen::Vector2d(contact.p_base.cast<double>());
    if (!point.allFinite())
      ++counters_.rejected;
    else if (!widen(needed, point / parameters_.resolution))
      ++counters_.outside_contacts;
  }
}

void OccupancyMap::growForRays(const Obstacles& obstacles, std::optional<Box>& needed) {
  for (const Bearing& bearing : obstacles.bearings) {
    if (bearing.state != BearingState::Unknown && !finite(bearing)) ++counters_.rejected;
    const auto ray = rayOf(bearing, obstacles.view);
    if (ray && !(widen(needed, ray->from) && widen(needed, ray->to))) ++counters_.outside_rays;
  }
}

/// Widens the box by whole blocks until it holds the point; false where it would get too large.
bool OccupancyMap::widen(std::optional<Box>& needed, const Eigen::Vector2d& cells) const {
  if (!usable(cells)) return false;
  const Cell cell = cellOf(cells);
  if (needed && needed->holds(cell)) return true;
  const Cell low{floorToMultiple(cell.x, block_), floorToMultiple(cell.y, block_)};
  const Cell high{low.x + block_ - 1, low.y + block_ - 1};
  const Box wider = needed ? needed->with(low).with(high) : Box{low, high};
  const bool fits =
      wider.high.x - wider.low.x < max_side_ && wider.high.y - wider.low.y < max_side_;
  if (fits) needed = wider;
  return fits;
}

void OccupancyMap::growTo(const std::optional<Box>& needed) {
  const std::optional<Box> old = stored();
  if (!needed || (old && old->low == needed->low && old->high == needed->high)) return;
  const MapGeometry before = geometry_;
  std::vector<float> content = std::move(log_odds_);
  geometry_.first = needed->low;
  geometry_.width = needed->high.x - needed->low.x + 1;
  geometry_.height = needed->high.y - needed->low.y + 1;
  ++geometry_.revision;
  const std::size_t size =
      static_cast<std::size_t>(geometry_.width) * static_cast<std::size_t>(geometry_.height);
  log_odds_.assign(size, never_seen);
  pending_.assign(size, no_change);
  for (int y = 0; y < before.height; ++y) {
    const auto from = content.begin() + static_cast<std::ptrdiff_t>(y) * before.width;
    const std::size_t to = indexOf({before.first.x, before.first.y + y});
    std::copy_n(from, before.width, log_odds_.begin() + static_cast<std::ptrdiff_t>(to));
  }
  changed_ = needed;
}

std::optional<OccupancyMap::Box> OccupancyMap::stored() const {
  if (geometry_.empty()) return std::nullopt;
  return Box{geometry_.first,
             {geometry_.first.x + geometry_.width - 1, geometry_.first.y + geometry_.height - 1}};
}

std::size_t OccupancyMap::indexOf(const Cell& world) const {
  return static_cast<std::size_t>(world.y - geometry_.first.y) *
             static_cast<std::size_t>(geometry_.width) +
         static_cast<std::size_t>(world.x - geometry_.first.x);
}

// --- what consumers read ---------------------------------------------------------

std::int8_t OccupancyMap::occupancy(std::size_t i) const {
  if (log_odds_[i] >= occupied_from_) return 100;
  if (log_odds_[i] <= free_up_to_) return 0;
  return -1;
}

std::int8_t OccupancyMap::probability(std::size_t i) const {
  if (std::isnan(log_odds_[i])) return -1;
  const double p = 1.0 / (1.0 + std::exp(-static_cast<double>(log_odds_[i])));
  return static_cast<std::int8_t>(std::lround(100.0 * p));
}

std::optional<float> OccupancyMap::logOdds(const Cell& world) const {
  const std::optional<Box> box = stored();
  if (!box || !box->holds(world) || std::isnan(log_odds_[indexOf(world)])) return std::nullopt;
  return log_odds_[indexOf(world)];
}

void OccupancyMap::copyTo(TrinaryMap& map) const {
  map.resolution = geometry_.resolution;
  map.origin_x = geometry_.originX();
  map.origin_y = geometry_.originY();
  map.width = geometry_.width;
  map.height = geometry_.height;
  map.cells.resize(log_odds_.size());
  for (std::size_t i = 0; i < log_odds_.size(); ++i) map.cells[i] = occupancy(i);
}

std::optional<MapRectangle> OccupancyMap::takeChanges() {
  if (!changed_) return std::nullopt;
  const MapRectangle rectangle{
      changed_->low.x - geometry_.first.x, changed_->low.y - geometry_.first.y,
      changed_->high.x - changed_->low.x + 1, changed_->high.y - changed_->low.y + 1};
  changed_.reset();
  return rectangle;
}

// --- an earlier map ----------------------------------------------------------------

float OccupancyMap::loadedValue(std::int8_t occupancy) const {
  const auto clamp = static_cast<float>(parameters_.clamp);
  if (occupancy == 100)
    return parameters_.update == MapUpdate::MarkOnce ? for_good : std::max(clamp, occupied_from_);
  return occupancy == 0 ? std::min(-clamp, free_up_to_) : never_seen;
}

std::optional<std::string> OccupancyMap::load(const TrinaryMap& map) {
  const double resolution = parameters_.resolution;
  if (std::abs(map.resolution - resolution) > 1e-6 * resolution)
    return "resolution " + std::to_string(map.resolution) +
           " m of the loaded map is not the map's " + std::to_string(resolution) + " m";
  if (map.width <= 0 || map.height <= 0 ||
      map.cells.size() !=
          static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height))
    return std::string("the loaded map has no cells");
  const Eigen::Vector2d corner(std::round(map.origin_x / resolution),
                               std::round(map.origin_y / resolution));
  const Eigen::Vector2d opposite = corner + Eigen::Vector2d(map.width - 1, map.height - 1);
  std::optional<Box> needed;
  if (!widen(needed, corner) || !widen(needed, opposite))
    return std::to_string(map.width) + " x " + std::to_string(map.height) +
           " cells of the loaded map do not fit map/max_side = " +
           std::to_string(parameters_.max_side);
  clear();
  growTo(needed);
  const Cell first = cellOf(corner);
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const int x = static_cast<int>(i) % map.width, y = static_cast<int>(i) / map.width;
    log_odds_[indexOf({first.x + x, first.y + y})] = loadedValue(map.cells[i]);
  }
  return std::nullopt;
}

}  // namespace ipm_mapping
