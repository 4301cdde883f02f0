#pragma once

#include <string>

namespace ipm_mapping::sim {

/// True when one of the arguments is --help or -h.
[[nodiscard]] inline bool asksForHelp(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (const std::string word = argv[i]; word == "--help" || word == "-h") return true;
  return false;
}

}  // namespace ipm_mapping::sim
