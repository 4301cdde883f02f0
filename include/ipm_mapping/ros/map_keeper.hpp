#pragma once

#include <optional>
#include <string>

#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"

namespace ipm_mapping {

/// Files of the map: saved below one folder and nowhere else, whole or not at all.
class MapKeeper {
 public:
  MapKeeper(OccupancyMap& map, const MapperParameters& parameters);
  /// Saves what the last autosave missed.
  ~MapKeeper();
  MapKeeper(const MapKeeper&) = delete;
  MapKeeper& operator=(const MapKeeper&) = delete;

  struct Saved {
    std::string path;                  ///< of the YAML file
    std::optional<std::string> error;  ///< why nothing was saved
  };
  [[nodiscard]] Saved save(const std::string& name) const;
  /// Makes the folder; why nothing can be saved there.
  [[nodiscard]] std::optional<std::string> makeFolder() const;

  /// Loads `initial_map`. A notice when the file is not there yet; throws std::runtime_error when
  /// it is there and cannot be used.
  [[nodiscard]] std::optional<std::string> loadInitialMap();

  /// The map has changed, or was emptied.
  void touch() { changed_ = true; }
  /// Saves under `autosave_name` if the map has changed since; also an empty one, so that what was
  /// thrown away does not come back with `initial_map`.
  [[nodiscard]] std::optional<std::string> autosave();

 private:
  [[nodiscard]] Saved write(const std::string& name) const;

  OccupancyMap& map_;
  MapperParameters parameters_;
  bool changed_ = false;
};

}  // namespace ipm_mapping
