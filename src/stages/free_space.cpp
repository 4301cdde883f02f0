#include "ipm_mapping/stages/free_space.hpp"

#include <algorithm>

namespace ipm_mapping {

void findPeaks(const std::vector<int>& histogram, bool single_bin, std::vector<Peak>& peaks) {
  peaks.clear();
  const int n = static_cast<int>(histogram.size());
  const auto at = [&](int i) {
    return i < 0 || i >= n ? 0 : histogram[static_cast<std::size_t>(i)];
  };
  for (int first = 0; first < n;) {
    int last = first;
    while (last + 1 < n && at(last + 1) == at(first)) ++last;
    const bool higher = at(first) > at(first - 1) && at(first) > at(last + 1);
    if (higher && (!single_bin || first == last))
      peaks.push_back({(first + last) / 2, at(first), false});
    first = last + 1;
  }
}

ValleyAreas valleyAreas(const std::vector<int>& histogram, const Peak& left, const Peak& right) {
  const int half = (right.bearing - left.bearing) / 2;
  ValleyAreas areas;
  const auto add = [&](int first, int last, int peak) {
    for (int j = first; j <= last; ++j) {
      const int value = histogram[static_cast<std::size_t>(j)];
      areas.A1 += value;
      areas.A2 += std::max(peak - value, 0);
    }
  };
  add(left.bearing, left.bearing + half, left.amplitude);
  add(right.bearing - half, right.bearing, right.amplitude);
  return areas;
}

void groupPeaks(const std::vector<int>& histogram, FreeSpaceRule rule, double valley_threshold,
                std::vector<Peak>& peaks) {
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    if (i == 0) {
      peaks[i].new_obstacle = true;
      continue;
    }
    const ValleyAreas areas = valleyAreas(histogram, peaks[i - 1], peaks[i]);
    const double weighted = areas.A2 * valley_threshold;
    peaks[i].new_obstacle =
        rule == FreeSpaceRule::DeepValley ? weighted > areas.A1 : areas.A1 > weighted;
  }
}

}  // namespace ipm_mapping
