#include "ipm_mapping/sweep/beam_sums.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {

void BeamSums::evaluate(ImageView<const std::int16_t> plane, int step) {
  const int first_lines = std::max(0, (plane.height - kernels::beam_lines) / step + 1);
  sums_.ensure(plane.width + 1, first_lines);
  for (int line = 0; line < first_lines; ++line)
    kernels::sumBeam(plane.row(line * step), plane.stride, plane.width, sums_.row(line));
}

}  // namespace ipm_mapping::sweep
