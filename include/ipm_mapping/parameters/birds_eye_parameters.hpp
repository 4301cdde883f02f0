#pragma once
// Parameters of the first architecture: bird's-eye view, polar and radial histograms.

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

/// Bird's-eye localisation (the source, §3.5, §3.6, §3.8).
struct BirdsEyeParameters {
  double span = 4.0;
  int n_bins = 80;
  double sector_share = 0.5;
  double radial_threshold = 0.5;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("span", self.span, Unit{"m"}, Range{0.5, 100.0},
          "floor that the width of the bird's-eye view covers");
    field("n_bins", self.n_bins, Unit{"bins"}, Range{8, 512},
          "bins of the polar histogram over the field of view");
    field("sector_share", self.sector_share, Unit{""}, Range{0.05, 1.0},
          "a peak's sector reaches down to this share of its amplitude");
    field("radial_threshold", self.radial_threshold, Unit{""}, Range{0.01, 1.0},
          "share of obstacle pixels at a radius that makes it the obstacle's distance");
  }
};

}  // namespace ipm_mapping
