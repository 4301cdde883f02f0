#include "ipm_mapping/stages/radial_histogram.hpp"

#include <cmath>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {

PolarGrid::PolarGrid(const Intrinsics& k, int n_bins, double left, double right)
    : n_bins_(n_bins), left_(left), right_(right) {
  n_radii_ = static_cast<int>(std::ceil(std::hypot(k.width, k.height))) + 1;
  const auto pixels = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  bin_.reserve(pixels);
  radius_.reserve(pixels);
  for (int V = 0; V < k.height; ++V) {
    for (int U = 0; U < k.width; ++U) {
      const double forward = k.cy - V, leftward = k.cx - U;
      const double bin =
          std::floor((std::atan2(leftward, forward) - left) / (right - left) * n_bins);
      bin_.push_back(bin >= 0.0 && bin < n_bins ? static_cast<std::uint16_t>(bin) : none);
      radius_.push_back(static_cast<std::uint16_t>(std::hypot(forward, leftward)));
    }
  }
}

void PolarGrid::count(GrayView birds_eye_mask, Counts& counts) const {
  const auto n = static_cast<std::size_t>(n_bins_);
  const auto cells = n * static_cast<std::size_t>(n_radii_);
  counts.bear.assign(n, 0);
  counts.obstacle.assign(cells, 0);
  counts.seen.assign(cells, 0);
  std::size_t pixel = 0;
  for (int V = 0; V < birds_eye_mask.height; ++V) {
    const std::uint8_t* row = birds_eye_mask.row(V);
    for (int U = 0; U < birds_eye_mask.width; ++U, ++pixel) {
      if (row[U] == mask::unseen || bin_[pixel] == none) continue;
      const std::size_t cell = bin_[pixel] * static_cast<std::size_t>(n_radii_) + radius_[pixel];
      ++counts.seen[cell];
      if (row[U] != mask::obstacle) continue;
      ++counts.obstacle[cell];
      ++counts.bear[bin_[pixel]];
    }
  }
}

Sector sectorOf(const std::vector<int>& bear, const Peak& peak, double share) {
  const double lowest = share * peak.amplitude;
  const auto inside = [&](int i) {
    return i >= 0 && i < static_cast<int>(bear.size()) &&
           bear[static_cast<std::size_t>(i)] >= lowest;
  };
  Sector sector{peak.bearing, peak.bearing};
  while (inside(sector.first - 1)) --sector.first;
  while (inside(sector.last + 1)) ++sector.last;
  return sector;
}

int firstRadius(const PolarGrid::Counts& counts, int n_radii, const Sector& sector,
                double threshold) {
  for (int r = 0; r < n_radii; ++r) {
    int obstacle = 0, seen = 0;
    for (int bin = sector.first; bin <= sector.last; ++bin) {
      const auto cell = static_cast<std::size_t>(bin) * static_cast<std::size_t>(n_radii) +
                        static_cast<std::size_t>(r);
      obstacle += counts.obstacle[cell];
      seen += counts.seen[cell];
    }
    if (seen > 0 && obstacle >= threshold * seen) return r;
  }
  return -1;
}

SeenRun seenRun(const PolarGrid::Counts& counts, int n_radii, int bin) {
  SeenRun run;
  const std::size_t base = static_cast<std::size_t>(bin) * static_cast<std::size_t>(n_radii);
  for (int r = 0; r < n_radii; ++r) {
    const bool seen = counts.seen[base + static_cast<std::size_t>(r)] > 0;
    if (seen && run.first < 0) run.first = r;
    if (seen) run.last = r;
    // Single radii without a pixel centre are an artefact of the raster, not unseen floor.
    if (!seen && run.first >= 0 && r - run.last > 1) break;
  }
  return run;
}

}  // namespace ipm_mapping
