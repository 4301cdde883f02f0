#include "ipm_mapping/sweep/beam_sums.hpp"

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {

void BeamSums::configure(int rows, int lines, int step) {
  step_ = step;
  const int beams = lines < kernels::beam_lines ? 0 : (lines - kernels::beam_lines) / step + 1;
  sums_.resize(rows + 1, beams);
}

void BeamSums::evaluate(ImageView<const std::int16_t> plane) {
  for (int beam = 0; beam < sums_.height(); ++beam)
    kernels::sumBeam(plane.row(beam * step_), plane.stride, plane.width, sums_.row(beam));
}

}  // namespace ipm_mapping::sweep
