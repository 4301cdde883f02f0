#pragma once

#include <string>

#include "ipm_mapping/parameters.hpp"

namespace ipm_mapping {

/// Reads a profile file: a map of groups, each a map of fields, on top of the built-in profile that
/// `profile:` names (`default` when it is left out). Validated. Throws ParameterError that names
/// file, line and parameter; for an unknown name also the known one that is nearest.
[[nodiscard]] Parameters readParametersYaml(const std::string& path);

/// The same from text; `source` stands for the file in messages.
[[nodiscard]] Parameters parseParametersYaml(const std::string& text, const std::string& source);

/// A built-in profile by its name, otherwise the profile file of that path.
[[nodiscard]] Parameters profileOrFile(const std::string& name_or_path);

/// A complete profile file with every field, its unit, range and meaning as comments. Reading it
/// back gives the same parameters, whatever `profile` it names as its base.
[[nodiscard]] std::string parametersYaml(const Parameters& parameters, const std::string& profile);

}  // namespace ipm_mapping
