#include "ipm_mapping/ros/map_keeper.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "ipm_mapping/mapping/map_io.hpp"
#include "ipm_mapping/ros/confined_path.hpp"

namespace ipm_mapping {
namespace {

std::string withoutSuffix(const std::string& name) {
  const std::filesystem::path path(name);
  const bool known = path.extension() == ".yaml" || path.extension() == ".pgm";
  return known ? (path.parent_path() / path.stem()).string() : name;
}

/// A file holds at least one cell.
TrinaryMap nothingKnown(double resolution) {
  TrinaryMap map;
  map.resolution = resolution;
  map.width = map.height = 1;
  map.cells = {-1};
  return map;
}

}  // namespace

MapKeeper::MapKeeper(OccupancyMap& map, const MapperParameters& parameters)
    : map_(map), parameters_(parameters) {}

MapKeeper::~MapKeeper() {
  if (parameters_.autosave_period > 0.0) (void)autosave();
}

MapKeeper::Saved MapKeeper::save(const std::string& name) const {
  if (map_.geometry().empty()) return {"", "the map is empty"};
  return write(name);
}

std::optional<std::string> MapKeeper::makeFolder() const {
  if (const auto error = confine(parameters_.directory, "map").error)
    return "maps cannot be saved in '" + parameters_.directory + "': " + *error;
  return std::nullopt;
}

MapKeeper::Saved MapKeeper::write(const std::string& name) const {
  const ConfinedPath stem = confine(parameters_.directory, withoutSuffix(name));
  if (stem.error) return {"", stem.error};
  TrinaryMap map;
  map_.copyTo(map);
  if (map_.geometry().empty()) map = nothingKnown(map.resolution);
  if (auto error = saveMap(map, stem.path)) return {"", error};
  return {stem.path + ".yaml", std::nullopt};
}

std::optional<std::string> MapKeeper::loadInitialMap() {
  if (parameters_.initial_map.empty()) return std::nullopt;
  const std::string path = expandHome(parameters_.initial_map);
  if (!std::filesystem::exists(path))
    return "initial_map '" + path + "' is not there: the map starts empty";
  TrinaryMap map;
  if (const auto error = loadMap(path, map)) throw std::runtime_error("initial_map: " + *error);
  const bool empty = std::all_of(map.cells.begin(), map.cells.end(), [](auto c) { return c < 0; });
  if (empty) return std::nullopt;  // it would bind the map to where it lies
  if (const auto error = map_.load(map)) throw std::runtime_error("initial_map: " + *error);
  return std::nullopt;
}

std::optional<std::string> MapKeeper::autosave() {
  if (!changed_) return std::nullopt;
  const Saved saved = write(parameters_.autosave_name);
  if (!saved.error) changed_ = false;
  return saved.error;
}

}  // namespace ipm_mapping
