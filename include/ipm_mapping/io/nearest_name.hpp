#pragma once

#include <string>
#include <vector>

namespace ipm_mapping {

/// The candidate with the fewest letters to change (Levenshtein), the first of equals; empty when
/// none is near enough to be what was meant (more than a third of the letters differ).
[[nodiscard]] std::string nearestName(const std::string& word,
                                      const std::vector<std::string>& candidates);

/// "; did you mean 'NEAREST'?", or nothing.
[[nodiscard]] std::string didYouMean(const std::string& word,
                                     const std::vector<std::string>& candidates);

}  // namespace ipm_mapping
