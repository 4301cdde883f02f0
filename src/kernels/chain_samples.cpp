#include "ipm_mapping/kernels/chain_samples.hpp"

#include <algorithm>

namespace ipm_mapping::kernels {

void Samples::resize(int width, int rows) {
  padded_ = (width + block - 1) / block * block;
  const auto n = static_cast<std::size_t>(padded_) * static_cast<std::size_t>(rows);
  u_.assign(n, 0);
  v_.assign(n, 0);
  way_.assign(n, sample_outside);
}

bool Samples::put(const Row& row, int u, double u_raw, double v_raw, int W, int H) {
  const double margin = 0.5 / sample_steps;
  if (!(u_raw > -margin && v_raw > -margin && u_raw < W - 1 + margin && v_raw < H - 1 + margin))
    return false;
  const auto split = [](double coordinate, int size, std::int16_t& pixel) {
    const int rounded = static_cast<int>(coordinate * sample_steps + 0.5);
    const int whole = std::min(rounded / sample_steps, size - 2);
    pixel = static_cast<std::int16_t>(whole);
    return rounded - whole * sample_steps;
  };
  const int right = split(u_raw, W, row.u[u]), down = split(v_raw, H, row.v[u]);
  row.way[u] = static_cast<std::uint16_t>(right | (down << 8));
  return true;
}

}  // namespace ipm_mapping::kernels
