#pragma once

#include <map>
#include <optional>
#include <string>

namespace ipm_mapping {

/// The reference of all parameters in Markdown: a table a group, what the profiles change, the
/// nodelets' own parameters.
[[nodiscard]] std::string parametersMarkdown();

/// What the README says about them: a table of those that one sets first, all of them folded away.
[[nodiscard]] std::string readmeParameters();

/// `text` with `part` in place of what stands between the two marks
///   <!-- parameters: written by describe_parameters ... -->
///   <!-- end of the parameters -->
/// Nothing when it has no such marks.
[[nodiscard]] std::optional<std::string> withGeneratedPart(const std::string& text,
                                                           const std::string& part);

/// The files of the repository that are written from the parameter structs, by path from its root:
/// config/PROFILE.yaml for every profile, docs/parameters.md.
[[nodiscard]] std::map<std::string, std::string> generatedFiles();

}  // namespace ipm_mapping
