#include "ipm_mapping/sweep/cylindrical_rectification.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/kernels/sweep_rectify.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double border = 2.0;  // pixels: the smoothing needs one, the interpolation another

/// Weights of the four neighbours in the order of the pair image's bytes: (0,0) (0,1) (1,0) (1,1)
/// as (u, v); they sum to 128 exactly.
std::uint32_t packedWeights(double du, double dv) {
  const std::array<double, 4> exact{(1 - du) * (1 - dv), (1 - du) * dv, du * (1 - dv), du * dv};
  std::array<int, 4> w{};
  int sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += w[i] = static_cast<int>(std::lround(128.0 * exact[i]));
  *std::max_element(w.begin(), w.end()) += 128 - sum;
  std::uint32_t packed = 0;
  for (std::size_t i = 0; i < 4; ++i) packed |= static_cast<std::uint32_t>(w[i]) << (8 * i);
  return packed;
}

}  // namespace

void commonRows(const std::vector<RowRange>& rows, int lines, std::vector<RowRange>& common) {
  common.clear();
  for (std::size_t first = 0; first + static_cast<std::size_t>(lines) <= rows.size(); ++first) {
    RowRange all = rows[first];
    for (int k = 1; k < lines; ++k)
      all = intersection(all, rows[first + static_cast<std::size_t>(k)]);
    common.push_back(all);
  }
}

std::vector<RowRange> commonRows(const std::vector<RowRange>& rows, int lines) {
  std::vector<RowRange> common;
  commonRows(rows, lines, common);
  return common;
}

void CylindricalRectification::configure(const CameraModel& camera, const CameraPose& T_base_camera,
                                         const PolarGrid& grid) {
  grid_ = grid;
  ranges_.assign(static_cast<std::size_t>(grid.lines), RowRange{});
  offsets_.resize(grid.rows, grid.lines);
  weights_.resize(grid.rows, grid.lines);
  u_.resize(grid.rows, grid.lines);
  v_.resize(grid.rows, grid.lines);
  gains_.resize(grid.rows, grid.lines);
  centre_u_ = 0.5F * static_cast<float>(camera.width() - 1);
  centre_v_ = 0.5F * static_cast<float>(camera.height() - 1);
  readout_per_row_ = 1.0F / static_cast<float>(std::max(1, camera.height() - 1));
  moved_offsets_.resize(static_cast<std::size_t>(grid.rows + kernels::overrun));
  moved_weights_.resize(moved_offsets_.size());
  smooth_.resize(camera.width(), camera.height());
  pairs_.resize(camera.width(), camera.height());
  for (int line = 0; line < grid.lines; ++line) compileLine(camera, T_base_camera, line);
  setShading(shading_);
}

void CylindricalRectification::setShading(double shading) {
  shading_ = shading;
  for (int line = 0; line < grid_.lines; ++line)
    for (int row = 0; row < grid_.rows; ++row)
      gains_.at(row, line) =
          rows(line).contains(row)
              ? static_cast<std::uint16_t>(std::clamp(
                    std::lround(kernels::no_gain /
                                (1.0 - shading * static_cast<double>(squaredRadius(row, line)))),
                    0L, 65535L))
              : kernels::no_gain;
}

void CylindricalRectification::shadeAgain(double before, ImageView<std::uint8_t> rectified) const {
  for (int line = 0; line < grid_.lines; ++line) {
    const RowRange seen = rows(line);
    for (int row = seen.begin; row < seen.end; ++row) {
      const auto rho2 = static_cast<double>(squaredRadius(row, line));
      const double grey = rectified.at(row, line) * (1.0 - before * rho2) / (1.0 - shading_ * rho2);
      rectified.at(row, line) = static_cast<std::uint8_t>(std::lround(std::min(grey, 255.0)));
    }
  }
}

/// A line is one plane through the camera: what the image shows of it is one run of rows.
void CylindricalRectification::compileLine(const CameraModel& camera,
                                           const CameraPose& T_base_camera, int line) {
  RowRange& range = ranges_[static_cast<std::size_t>(line)];
  for (int row = 0; row < grid_.rows; ++row) {
    double u = 0.0, v = 0.0;
    const bool seen = rawPixel(camera, T_base_camera, grid_.azimuth(line), grid_.r(row), u, v) &&
                      u >= border && v >= border && u < camera.width() - 1 - border &&
                      v < camera.height() - 1 - border;
    if (!seen && range.size() > 0) break;
    if (!seen) continue;
    if (range.size() == 0) range = {row, row};
    range.end = row + 1;
    const int iu = static_cast<int>(u), iv = static_cast<int>(v);
    offsets_.at(row, line) = (iv * camera.width() + iu) * 2;
    weights_.at(row, line) = packedWeights(u - iu, v - iv);
    u_.at(row, line) = static_cast<float>(u);
    v_.at(row, line) = static_cast<float>(v);
  }
}

void CylindricalRectification::load(GrayView raw) {
  kernels::smooth121(raw, smooth_.view());
  kernels::pairRows(smooth_.view(), pairs_.view());
}

void CylindricalRectification::sampleMoved(int line, RowRange part, const kernels::MovedRows& moved,
                                           std::uint8_t* out) {
  const kernels::RawLine raw{u_.row(line),     v_.row(line),     u_.row(line - 1),
                             v_.row(line - 1), u_.row(line + 1), v_.row(line + 1)};
  const kernels::RawBounds bounds{
      static_cast<float>(border), static_cast<float>(smooth_.width() - 1 - border),
      static_cast<float>(smooth_.height() - 1 - border), readout_per_row_, smooth_.width()};
  kernels::movedPlan(raw, moved, bounds, part.begin, part.end, moved_offsets_.data(),
                     moved_weights_.data());
  kernels::samplePlan(pairs_.view(), moved_offsets_.data(), moved_weights_.data(),
                      gains_.row(line) + part.begin, part.size(), out + part.begin);
}

void CylindricalRectification::rectify(GrayView raw, const std::vector<RowRange>& rows,
                                       ImageView<std::uint8_t> rectified) {
  load(raw);
  for (int line = 0; line < grid_.lines; ++line) {
    const RowRange range = rows[static_cast<std::size_t>(line)];
    kernels::samplePlan(pairs_.view(), offsets_.row(line) + range.begin,
                        weights_.row(line) + range.begin, gains_.row(line) + range.begin,
                        range.size(), rectified.row(line) + range.begin);
  }
}

}  // namespace ipm_mapping::sweep
