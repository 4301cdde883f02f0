#include "ipm_mapping/sweep/beam_sums.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/kernels/sweep_sums.hpp"

namespace ipm_mapping::sweep {

void BeamSums::configure(int rows, int lines, int step) {
  step_ = step;
  const int beams = lines < kernels::beam_lines ? 0 : (lines - kernels::beam_lines) / step + 1;
  sums_.resize(rows + 1, beams);
  column_.resize(static_cast<std::size_t>(rows));
}

void BeamSums::evaluate(ImageView<const std::int16_t> plane) {
  std::fill(column_.begin(), column_.end(), 0);
  int summed = 0;  // lines that were taken into the column, the last beam_lines of them are in it
  for (int beam = 0; beam < sums_.height(); ++beam) {
    for (const int end = beam * step_ + kernels::beam_lines; summed < end; ++summed) {
      kernels::addLineTo(plane.row(summed), 1, plane.width, column_.data());
      if (summed >= kernels::beam_lines)
        kernels::addLineTo(plane.row(summed - kernels::beam_lines), -1, plane.width,
                           column_.data());
    }
    kernels::prefixSums(column_.data(), plane.width, sums_.row(beam));
  }
}

}  // namespace ipm_mapping::sweep
