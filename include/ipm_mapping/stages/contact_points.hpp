#pragma once

#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/stages/polar_histogram.hpp"

namespace ipm_mapping {

/// The vertex of one quasi triangle on a line: where an obstacle meets the floor.
struct TriangleContact {
  int line = 0;
  int u = 0, v = 0;
  int score = 0;    ///< Sc of eq. 5.8 or 5.16
  int surface = 0;  ///< S of eq. 5.12, pixels
  int height = 0;   ///< h of eq. 5.14, rows
};

/// What one line of the beam met.
struct LineContacts {
  int nearest = -1;      ///< index of the contact nearest to the robot, -1: none
  int blocked_row = -1;  ///< lowest row of the lowest run of obstacle pixels without a contact
};

/// Follows every line from top to bottom and finds the triangles that it crosses (the source, §5.3,
/// §6.8.1.2). `a` = obstacle pixels in the window u-l ... u+l of the row; a triangle is a run of
/// obstacle pixels on the line along which `a` shrinks, and ends in a vertex: the contact.
class ContactFinder {
 public:
  /// beam: has sampled obstacle_mask. lines: one entry a line of the beam. contacts(): all, line by
  /// line, top to bottom.
  void find(const PolarBeam& beam, GrayView obstacle_mask, const LocalizationParameters& parameters,
            std::vector<LineContacts>& lines);
  [[nodiscard]] const std::vector<TriangleContact>& contacts() const { return contacts_; }
  /// At least as many contacts as any mask of this size can hold.
  [[nodiscard]] std::size_t most() const { return contacts_.capacity(); }

 private:
  struct Triangle;
  void follow(const PolarBeam& beam, int line, GrayView obstacle_mask,
              const LocalizationParameters& parameters, LineContacts& result);
  void close(Triangle& triangle, bool clipped, const LocalizationParameters& parameters,
             LineContacts& result);

  std::vector<TriangleContact> contacts_;
};

/// Obstacle pixels in columns u-l ... u+l of one row of the mask; outside counts 0.
[[nodiscard]] int windowSum(const std::uint8_t* row, int width, int u, int half_width);

}  // namespace ipm_mapping
