#pragma once
// Scenes as YAML files and as JSON.

#include <string>
#include <utility>
#include <vector>

#include "ipm_mapping_sim/scene.hpp"

namespace ipm_mapping::sim {

/// A change to a scene before it is read: dotted path ("camera.pitch_error", "lamps.0.size") and
/// the value as YAML text.
using Override = std::pair<std::string, std::string>;

/// Reads a scene file. An entry `base: OTHER.yaml` starts from another scene in the same folder and
/// changes only what is given. Throws ParameterError naming the entry, its value and what is
/// allowed, for unknown entries too; std::runtime_error if the file cannot be read.
Scene loadScene(const std::string& path, const std::vector<Override>& overrides = {});

/// The same from YAML text.
Scene parseScene(const std::string& text, const std::vector<Override>& overrides = {});

/// Every field of the scene as a JSON object.
std::string sceneJson(const Scene& scene);

}  // namespace ipm_mapping::sim
