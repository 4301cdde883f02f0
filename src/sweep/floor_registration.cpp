#include "ipm_mapping/sweep/floor_registration.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "ipm_mapping/sweep/floor_sample.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int side = 28;        // rows and lines of a patch
constexpr int sample_step = 2;  // rows and lines between its samples
constexpr int steps = 8;
constexpr double farthest_shift = 10.0;  // grid steps
constexpr double settled = 0.05;         // grid steps
constexpr double least_texture = 0.25;   // weaker eigenvalue of the mean structure tensor, grey^2
constexpr double least_likeness = 0.75;

/// One sample of a patch: grey level of the current view, position in the reference.
struct PatchSample {
  double grey, row, line;
};

/// What a patch says about its shift, by the reference's slopes.
struct PatchNormal {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  double cc = 0.0, cr = 0.0, rr = 0.0;
  int number = 0;
  [[nodiscard]] double likeness() const { return cr / std::sqrt(std::max(cc * rr, 1e-9)); }
  [[nodiscard]] bool textured() const {
    return A.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() > least_texture * number;
  }
};

double highPassed(const RectifiedFrame& frame, double value, double row, double line) {
  return value -
         static_cast<double>(frame.mean.at(static_cast<float>(row), static_cast<float>(line)));
}

/// Samples of a patch; empty unless both views see nearly all of it.
std::vector<PatchSample> samplesOf(const FramePair& pair, const FloorPair& floor,
                                   const FloorWarp& warp, int first_row, int first_line) {
  std::vector<PatchSample> samples;
  int all = 0;
  for (int line = first_line; line < first_line + side; line += sample_step) {
    for (int row = first_row; row < first_row + side; row += sample_step) {
      ++all;
      FloorWarp::Position at;
      if (!floor.rows()[static_cast<std::size_t>(line)].contains(row) ||
          !floor.place(warp, row, line, at))
        continue;
      samples.push_back(
          {highPassed(pair.current, pair.current.image.at(row, line), row, line), at.row, at.line});
    }
  }
  if (static_cast<int>(samples.size()) * 10 < all * 9) samples.clear();
  return samples;
}

PatchNormal compare(const std::vector<PatchSample>& samples, const FramePair& pair,
                    const FloorPair& floor, const Eigen::Vector2d& shift) {
  PatchNormal normal;
  for (const PatchSample& s : samples) {
    FloorWarp::Position at;
    at.row = s.row + shift.x();
    at.line = s.line + shift.y();
    if (!floor.inView(at)) continue;
    const GreyPatch patch = greyPatch(pair.reference.image, at.row, at.line);
    const double grey = highPassed(pair.reference, patch.value, at.row, at.line);
    const Eigen::Vector2d J(patch.by_row, patch.by_line);
    normal.A += J * J.transpose();
    normal.b += J * (s.grey - grey);
    normal.cc += s.grey * s.grey;
    normal.cr += s.grey * grey;
    normal.rr += grey * grey;
    ++normal.number;
  }
  return normal;
}

/// Shift in grid steps, if the patch finds its place.
std::optional<Eigen::Vector2d> shiftOf(const std::vector<PatchSample>& samples,
                                       const FramePair& pair, const FloorPair& floor) {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  for (int i = 0; i < steps; ++i) {
    const PatchNormal normal = compare(samples, pair, floor, shift);
    if (normal.number * 2 < static_cast<int>(samples.size()) || !normal.textured())
      return std::nullopt;
    const Eigen::Vector2d delta = normal.A.inverse() * normal.b;
    shift += delta;
    if (!(shift.norm() < farthest_shift)) return std::nullopt;
    if (delta.norm() < settled && normal.likeness() > least_likeness) return shift;
  }
  return std::nullopt;
}

}  // namespace

std::vector<PatchShift> floorRegistration(const FramePair& pair, const FloorPair& floor,
                                          const PairEvidence& alignment, const CameraModel& camera,
                                          const CameraPose& T_base_rectified) {
  const PolarGrid& grid = floor.grid();
  const FloorWarp warp = floor.warp(pair, alignment.state, alignment.motion, alignment.sway);
  const auto pixelAt = [&](double row, double line) {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    (void)rawPixel(camera, T_base_rectified, grid.azimuth(line), grid.r(row), pixel.x(), pixel.y());
    return pixel;
  };
  std::vector<PatchShift> shifts;
  for (int line = 1; line + side < grid.lines - 1; line += side) {
    for (int row = floor.firstRow(); row + side < grid.rows; row += side) {
      const std::vector<PatchSample> samples = samplesOf(pair, floor, warp, row, line);
      if (samples.empty()) continue;
      const auto shift = shiftOf(samples, pair, floor);
      if (!shift) continue;
      const PatchSample& middle = samples[samples.size() / 2];
      shifts.push_back({pixelAt(row + 0.5 * side, line + 0.5 * side),
                        pixelAt(middle.row + shift->x(), middle.line + shift->y()) -
                            pixelAt(middle.row, middle.line)});
    }
  }
  return shifts;
}

}  // namespace ipm_mapping::sweep
