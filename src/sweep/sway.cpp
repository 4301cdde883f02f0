#include "ipm_mapping/sweep/sway.hpp"

#include <algorithm>

#include "ipm_mapping/kernels/sway_line.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int beside = 2;  // lines from which a sway may fetch

}  // namespace

void SwayCorrection::configure(const PolarGrid& grid, const std::vector<RowRange>& rows) {
  grid_ = grid;
  const std::vector<RowRange> shared = commonRows(rows, 2 * beside + 1);
  rows_.assign(rows.size(), {});
  for (std::size_t i = 0; i < shared.size(); ++i) rows_[i + beside] = shared[i];
  cos_.clear();
  sin_.clear();
  for (int line = 0; line < grid.lines; ++line) {
    cos_.push_back(static_cast<float>(std::cos(grid.azimuth(line))));
    sin_.push_back(static_cast<float>(std::sin(grid.azimuth(line))));
  }
  const auto padded = static_cast<std::size_t>(grid.rows + kernels::overrun);
  r_.assign(padded, 1.0F);
  stretch_.assign(padded, 1.0F);
  for (int row = 0; row < grid.rows; ++row) {
    const double r = grid.r(row);
    r_[static_cast<std::size_t>(row)] = static_cast<float>(r);
    stretch_[static_cast<std::size_t>(row)] = static_cast<float>((1.0 + r * r) / r);
  }
}

/// A shift across lines stays within those whose rows are known to be in view.
float SwayCorrection::across(float lines, float r_most) {
  const float most = static_cast<float>(beside) / r_most;
  return std::clamp(lines, -most, most);
}

/// The rows that are fetched from rows in view.
RowRange SwayCorrection::reached(RowRange moved, float along) const {
  const auto from = [&](int row) {
    return static_cast<float>(row) + along * stretch_[static_cast<std::size_t>(row)];
  };
  RowRange rows = moved;
  while (rows.size() > 0 && from(rows.begin) < static_cast<float>(moved.begin)) ++rows.begin;
  while (rows.size() > 0 && from(rows.end - 1) > static_cast<float>(moved.end - 1)) --rows.end;
  return rows;
}

void SwayCorrection::remove(const Sway& sway, const Image<std::uint8_t>& image,
                            Image<std::uint8_t>& out, std::vector<RowRange>& seen) const {
  seen.resize(rows_.size());
  const auto pitch = static_cast<float>(sway.pitch), roll = static_cast<float>(sway.roll);
  const auto rows_per_log = static_cast<float>(grid_.rows_per_log);
  const auto lines_per_radian = static_cast<float>(grid_.lines_per_radian);
  for (int line = 0; line < grid_.lines; ++line) {
    const auto i = static_cast<std::size_t>(line);
    const RowRange moved = rows_[i].size() < 2 ? RowRange{} : rows_[i];
    const kernels::SwayShift shift{stretch_.data(), r_.data(),
                                   -rows_per_log * (pitch * cos_[i] - roll * sin_[i]),
                                   across(lines_per_radian * (pitch * sin_[i] + roll * cos_[i]),
                                          r_[static_cast<std::size_t>(grid_.rows - 1)])};
    seen[i] = reached(moved, shift.along);
    kernels::swayLine(image.view(), line, shift, moved.begin, moved.end, out.row(line));
    std::copy(image.row(line), image.row(line) + moved.begin, out.row(line));
    std::copy(image.row(line) + moved.end, image.row(line) + grid_.rows, out.row(line) + moved.end);
  }
}

}  // namespace ipm_mapping::sweep
