#pragma once

#include <optional>
#include <string>

namespace ipm_mapping {

/// Writes a file so that a reader, or a loss of power, finds either the old content or the new one,
/// never a part: temporary file in the same folder, fsync, rename. Nothing on success, otherwise
/// what failed, with the path.
[[nodiscard]] std::optional<std::string> writeFileAtomically(const std::string& path,
                                                             const std::string& content);

/// Reads a whole file; nothing on success, otherwise what failed, with the path.
[[nodiscard]] std::optional<std::string> readFile(const std::string& path, std::string& content);

}  // namespace ipm_mapping
