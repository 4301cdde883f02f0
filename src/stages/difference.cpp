#include "ipm_mapping/stages/difference.hpp"

#include "ipm_mapping/kernels/chain_segment.hpp"

namespace ipm_mapping {

void absoluteDifference(GrayView a, GrayView b, GrayView valid, GrayBuffer difference) {
  for (int v = 0; v < a.height; ++v)
    kernels::differenceRow(a.row(v), b.row(v), valid.row(v), a.width, difference.row(v));
}

}  // namespace ipm_mapping
