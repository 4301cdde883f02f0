#pragma once
// How far two implementations of the same chain are apart on one frame (the source, §7.2.1).

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/obstacles.hpp"

namespace ipm_mapping {

/// Two pictures of one stage, pixel by pixel.
struct PictureComparison {
  std::uint32_t compared = 0;   ///< pixels that both sides have seen
  std::uint32_t changed = 0;    ///< of these, pixels with different values
  std::uint32_t seen_once = 0;  ///< pixels that only one side has seen
  int max = 0;                  ///< greatest difference of the compared pixels
  double mean = 0.0;            ///< over the compared pixels
  bool same_size = true;        ///< false: nothing was compared

  [[nodiscard]] bool equal() const { return same_size && changed == 0 && seen_once == 0; }
};

/// Grey levels where `valid` is not 0; a side's `valid` has the size of its picture.
[[nodiscard]] PictureComparison compareDifferences(GrayView a, GrayView valid_a, GrayView b,
                                                   GrayView valid_b);

/// Masks of mask::floor, unseen and obstacle; obstacle against floor is a difference of 1.
[[nodiscard]] PictureComparison compareMasks(GrayView a, GrayView b);

/// Contacts of two answers, every point against the nearest one of the other side.
struct PointComparison {
  std::size_t points_a = 0, points_b = 0;
  double mean_distance = 0.0;  ///< m on the floor, over the points of both sides
  double max_distance = 0.0;   ///< m; the Hausdorff distance

  [[nodiscard]] bool equal() const { return points_a == points_b && max_distance == 0.0; }
};

/// Distances are 0 when neither side has a point, and NaN when just one has.
[[nodiscard]] PointComparison compareContacts(const std::vector<Contact>& a,
                                              const std::vector<Contact>& b);

}  // namespace ipm_mapping
