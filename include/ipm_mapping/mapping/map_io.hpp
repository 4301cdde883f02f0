#pragma once

#include <optional>
#include <string>

#include "ipm_mapping/mapping/occupancy_map.hpp"

namespace ipm_mapping {

/// Writes STEM.pgm and STEM.yaml as map_server's map_saver does (trinary; row 0 of the picture is
/// the top, the largest y): 0 occupied, 254 free, 205 unknown. Whenever it is interrupted,
/// STEM.yaml and the picture that it names belong to one map, the old or the new one. Nothing on
/// success, otherwise one sentence with the path.
[[nodiscard]] std::optional<std::string> saveMap(const TrinaryMap& map, const std::string& stem);

/// Reads a map_server YAML with its PGM (8 bit; P5 or P2; `mode: trinary`, no rotation). Nothing on
/// success, otherwise one sentence with the file and the field; then `map` stays as it was.
[[nodiscard]] std::optional<std::string> loadMap(const std::string& yaml_path, TrinaryMap& map);

}  // namespace ipm_mapping
