#include "ipm_mapping/stages/difference.hpp"

namespace ipm_mapping {

void absoluteDifference(GrayView a, GrayView b, GrayView valid, GrayBuffer difference) {
  for (int v = 0; v < a.height; ++v) {
    const std::uint8_t* pa = a.row(v);
    const std::uint8_t* pb = b.row(v);
    const std::uint8_t* seen = valid.row(v);
    std::uint8_t* out = difference.row(v);
    for (int u = 0; u < a.width; ++u) {
      const int d = pa[u] > pb[u] ? pa[u] - pb[u] : pb[u] - pa[u];
      out[u] = static_cast<std::uint8_t>(seen[u] ? d : 0);
    }
  }
}

}  // namespace ipm_mapping
