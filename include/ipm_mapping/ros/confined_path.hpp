#pragma once

#include <optional>
#include <string>

namespace ipm_mapping {

/// `~/x` with the user's home in place of `~`.
[[nodiscard]] std::string expandHome(const std::string& path);

/// Where `name` lies below `directory`, links followed: what callers of a service may write to.
struct ConfinedPath {
  std::string path;                  ///< empty when refused
  std::optional<std::string> error;  ///< why it was refused
};
/// Refuses absolute names and whatever leads out of the directory. Creates the folders.
[[nodiscard]] ConfinedPath confine(const std::string& directory, const std::string& name);

}  // namespace ipm_mapping
