#pragma once

#include <map>
#include <string>

namespace ipm_mapping {

/// The reference of all parameters in Markdown: a table a group, what the profiles change, the
/// nodelets' own parameters.
[[nodiscard]] std::string parametersMarkdown();

/// The files of the repository that are written from the parameter structs, by path from its root:
/// config/PROFILE.yaml for every profile, docs/parameters.md.
[[nodiscard]] std::map<std::string, std::string> generatedFiles();

}  // namespace ipm_mapping
