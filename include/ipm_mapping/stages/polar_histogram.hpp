#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/vanishing_point.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"

namespace ipm_mapping {

/// A beam of lines from the first image row to the focus, one pixel a row (the source, §5.2,
/// §6.8.1). Line 0 is the leftmost.
class PolarBeam {
 public:
  static constexpr std::int16_t outside = -1;

  /// Lays the beam over a W x H picture; false where the focus leaves nothing to scan (it lies on
  /// or above the first row). Full view: lines follow the exact direction and cover the picture to
  /// its lower corners. Source: starting columns (8i + 4) W / 640 and algorithm 2, step before
  /// test.
  bool aim(const Focus& focus, int width, int height, int n_lines, Beam kind);

  [[nodiscard]] int lines() const { return lines_; }
  [[nodiscard]] int height() const { return height_; }
  /// Columns of line i, one a row from row 0 on; `outside` where the line is not in the picture
  /// or the row is not above the focus.
  [[nodiscard]] const std::int16_t* columns(int line) const {
    return columns_.data() + static_cast<std::ptrdiff_t>(line) * height_;
  }

  /// Reads the mask along every line; obstacle_mask: mask::floor, unseen or obstacle, of the beam's
  /// size.
  void sample(GrayView obstacle_mask);
  /// What line i met at the last sample(), one value a row; mask::unseen where columns() is outside.
  [[nodiscard]] const std::uint8_t* values(int line) const {
    return values_.data() + static_cast<std::ptrdiff_t>(line) * height_;
  }

 private:
  bool aimFullView(const Focus& focus);
  bool aimSource(const Focus& focus);
  /// First row that is not above the focus.
  [[nodiscard]] int endRow(const Focus& focus) const;
  std::int16_t* writableColumns(int line) {
    return columns_.data() + static_cast<std::ptrdiff_t>(line) * height_;
  }

  int lines_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::int16_t> columns_;
  std::vector<std::uint8_t> values_;
};

/// What the pixels of every line of a beam say.
struct PolarHistogram {
  std::vector<int> obstacle;  ///< bear[i]: obstacle pixels on line i
  std::vector<int> seen;      ///< pixels on line i that are floor or obstacle

  /// beam: sampled.
  void count(const PolarBeam& beam);
};

}  // namespace ipm_mapping
