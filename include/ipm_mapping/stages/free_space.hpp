#pragma once

#include <vector>

#include "ipm_mapping/parameters/chain_parameters.hpp"

namespace ipm_mapping {

/// A peak of the polar histogram.
struct Peak {
  int bearing = 0;
  int amplitude = 0;
  bool new_obstacle = false;  ///< it does not belong to the obstacle of the peak before it
};

/// Peaks of the histogram, left to right: runs of equal values > 0, strictly higher than both
/// neighbours (outside = 0), at the middle of the run rounded down. `single_bin`: only runs of one.
void findPeaks(const std::vector<int>& histogram, bool single_bin, std::vector<Peak>& peaks);

/// A1 = area under the histogram between two peaks, A2 = area of the valley below them, each half
/// measured from its own peak (the source, §3.7, algorithm 1 with its sums zeroed for every pair).
struct ValleyAreas {
  int A1 = 0;
  int A2 = 0;
};
[[nodiscard]] ValleyAreas valleyAreas(const std::vector<int>& histogram, const Peak& left,
                                      const Peak& right);

/// Marks the peaks that begin a new obstacle. Deep valley: A2 * threshold > A1 separates (§3.7);
/// printed: A1 > A2 * threshold (§6.9). Equality: the same obstacle.
void groupPeaks(const std::vector<int>& histogram, FreeSpaceRule rule, double valley_threshold,
                std::vector<Peak>& peaks);

}  // namespace ipm_mapping
