#include "ipm_mapping/ros/confined_path.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace ipm_mapping {
namespace {

namespace fs = std::filesystem;

bool isBelow(const fs::path& path, const fs::path& directory) {
  const auto [end, rest] =
      std::mismatch(directory.begin(), directory.end(), path.begin(), path.end());
  return end == directory.end() && rest != path.end();
}

ConfinedPath refuse(const std::string& name, const std::string& why) {
  return {"", "'" + name + "' " + why};
}

ConfinedPath resolve(const fs::path& directory, const std::string& name) {
  fs::create_directories(directory);
  const fs::path root = fs::canonical(directory);
  const fs::path path = fs::weakly_canonical(root / name);
  if (!isBelow(path, root)) return refuse(name, "leads out of '" + root.string() + "'");
  fs::create_directories(path.parent_path());
  return {path.string(), std::nullopt};
}

}  // namespace

std::string expandHome(const std::string& path) {
  const char* home = std::getenv("HOME");
  const bool here = path == "~" || path.compare(0, 2, "~/") == 0;
  return here && home != nullptr ? home + path.substr(1) : path;
}

ConfinedPath confine(const std::string& directory, const std::string& name) {
  if (name.empty() || name.find('\0') != std::string::npos)
    return refuse(name, "is not the name of a file");
  if (fs::path(name).is_absolute() || fs::path(name).filename().empty())
    return refuse(name, "has to be a name below '" + directory + "'");
  try {
    return resolve(expandHome(directory), name);
  } catch (const std::exception& error) {
    return refuse(name, std::string("cannot be used: ") + error.what());
  }
}

}  // namespace ipm_mapping
