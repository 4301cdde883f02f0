#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"

namespace ipm_mapping::sweep {

/// Blocks of 8 x 8 pixels of the polar grid: how many are in view. Fixed per camera.
class BlockLattice {
 public:
  static constexpr int side = 8;

  void configure(const PolarGrid& grid, const std::vector<RowRange>& rows);
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int lines() const { return lines_; }
  [[nodiscard]] int pixels(int block_row, int block_line) const {
    return pixels_.at(block_row, block_line);
  }

 private:
  int rows_ = 0, lines_ = 0;
  Image<std::int32_t> pixels_;
};

/// Mean grey level around each block (3 x 3 blocks, pixels in view only), bilinear in between: what
/// a high-pass takes away.
class LocalMean {
 public:
  void evaluate(const BlockLattice& lattice, ImageView<const std::uint8_t> rectified);
  /// Mean around a pixel of the polar grid.
  [[nodiscard]] float at(float row, float line) const;

 private:
  Image<std::int32_t> sums_;
  Image<float> means_;
};

}  // namespace ipm_mapping::sweep
