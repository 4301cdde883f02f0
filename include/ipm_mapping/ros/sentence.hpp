#pragma once

#include <sstream>
#include <string>

namespace ipm_mapping {

/// Prints its arguments one after the other.
template <class... Parts>
[[nodiscard]] std::string sentence(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

}  // namespace ipm_mapping
