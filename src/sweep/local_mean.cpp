#include "ipm_mapping/sweep/local_mean.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/sweep_sums.hpp"

namespace ipm_mapping::sweep {

void BlockLattice::configure(const PolarGrid& grid, const std::vector<RowRange>& rows) {
  rows_ = (grid.rows + side - 1) / side;
  lines_ = (grid.lines + side - 1) / side;
  pixels_.resize(rows_, lines_);
  for (int line = 0; line < grid.lines; ++line) {
    const RowRange range = rows[static_cast<std::size_t>(line)];
    for (int row = range.begin; row < range.end; ++row) ++pixels_.at(row / side, line / side);
  }
}

void LocalMean::evaluate(const BlockLattice& lattice, ImageView<const std::uint8_t> rectified) {
  sums_.resize(lattice.rows(), lattice.lines());
  means_.ensure(lattice.rows(), lattice.lines());
  for (int line = 0; line < rectified.height; ++line)
    kernels::addBlockSums(rectified.row(line), lattice.rows(),
                          sums_.row(line / BlockLattice::side));
  for (int l = 0; l < lattice.lines(); ++l) {
    for (int r = 0; r < lattice.rows(); ++r) {
      int sum = 0, number = 0;
      for (int dl = std::max(l - 1, 0); dl <= std::min(l + 1, lattice.lines() - 1); ++dl)
        for (int dr = std::max(r - 1, 0); dr <= std::min(r + 1, lattice.rows() - 1); ++dr) {
          sum += sums_.at(dr, dl);
          number += lattice.pixels(dr, dl);
        }
      means_.at(r, l) = static_cast<float>(sum) / static_cast<float>(std::max(number, 1));
    }
  }
}

float LocalMean::at(float row, float line) const {
  constexpr float scale = 1.0F / BlockLattice::side;
  const float r = std::clamp(row * scale - 0.5F, 0.0F, static_cast<float>(means_.width()) - 1.001F);
  const float l =
      std::clamp(line * scale - 0.5F, 0.0F, static_cast<float>(means_.height()) - 1.001F);
  const int ir = static_cast<int>(r), il = static_cast<int>(l);
  const float a = r - static_cast<float>(ir), b = l - static_cast<float>(il);
  const float* p = means_.row(il) + ir;
  const float* q = means_.row(il + 1) + ir;
  return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1]);
}

}  // namespace ipm_mapping::sweep
