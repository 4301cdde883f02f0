#include "ipm_mapping/sweep/lens_shading.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "ipm_mapping/sweep/floor_sample.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double tukey = 2.5;
constexpr int rounds = 3;
constexpr double least_sigma = 1.0;  // grey levels
constexpr double white = 250.0;      // brighter ones may be clipped
constexpr double weak_prior = 1e-6;  // keeps what does not differ within the view solvable
constexpr double least_information = 1.0;
constexpr double gain_scale = 100.0;  // keeps the normal equations well conditioned

}  // namespace

void LensShading::forget() {
  sum_ = information_ = 0.0;
  pairs_ = 0;
}

void LensShading::adopt(const LensShading& other) {
  sum_ = other.sum_;
  information_ = other.information_;
  pairs_ = other.pairs_;
}

double LensShading::priorInformation() const {
  return 1.0 / (parameters_.sd_shading * parameters_.sd_shading);
}

double LensShading::estimate() const {
  const double prior = priorInformation();
  return std::clamp((prior * parameters_.lens_shading + sum_) / (prior + information_),
                    std::min(0.0, parameters_.lens_shading), parameters_.max_shading);
}

double LensShading::sigma() const { return 1.0 / std::sqrt(priorInformation() + information_); }

bool LensShading::differs(double in_force) const {
  const double off = std::abs(estimate() - in_force);
  return pairs_ >= parameters_.shading_pairs && off > parameters_.apply_shading &&
         off > parameters_.shading_sigmas * sigma();
}

/// What each sample's change moves with, as in the class's equation.
void LensShading::fillRows(const CylindricalRectification& rectification,
                           const FloorSamples& floor) {
  const PolarGrid& grid = rectification.grid();
  rows_.clear();
  for (int i = 0; i < floor.count; ++i) {
    const auto grey = static_cast<double>(floor.current[i]);
    if (grey > white) continue;
    const int before_row = static_cast<int>(std::lround(floor.reference_row[i]));
    const int before_line = static_cast<int>(std::lround(floor.reference_line[i]));
    const double farther = floor.row[i] - static_cast<double>(floor.reference_row[i]);
    const double outwards =
        static_cast<double>(rectification.squaredRadius(floor.row[i], floor.line[i]) -
                            rectification.squaredRadius(before_row, before_line));
    rows_.push_back({{-grey * outwards, grey / gain_scale, 1.0, grey * farther / grid.rows_per_log,
                      grey * (grid.r(floor.row[i]) - grid.r(before_row))},
                     grey - static_cast<double>(floor.before[i])});
  }
}

/// One robust round around a solution.
void LensShading::Fit::add(const std::vector<Row>& rows, double limit) {
  const Unknowns around = solution;
  std::array<double, unknowns*(unknowns + 1) / 2> upper{};
  b.setZero();
  for (const Row& row : rows) {
    double left = row.change;
    for (int k = 0; k < unknowns; ++k) left -= row.slopes[static_cast<std::size_t>(k)] * around[k];
    const double weight = tukeyWeight(left, limit);
    if (weight == 0.0) continue;
    std::size_t at = 0;
    for (std::size_t k = 0; k < unknowns; ++k) {
      const double weighed = weight * row.slopes[k];
      b[static_cast<int>(k)] += weighed * row.change;
      for (std::size_t j = k; j < unknowns; ++j) upper[at++] += weighed * row.slopes[j];
    }
  }
  auto next = upper.begin();
  for (int k = 0; k < unknowns; ++k)
    for (int j = k; j < unknowns; ++j) A(k, j) = A(j, k) = *next++;
  A.diagonal().array() += weak_prior;
  solution = A.llt().solve(b);
}

void LensShading::learn(const CylindricalRectification& rectification, const FloorSamples& floor) {
  if (floor.count < parameters_.min_samples) return;
  const double sigma = std::max(least_sigma, floor.sigma);
  fillRows(rectification, floor);
  Fit fit;
  for (int round = 0; round < rounds; ++round) fit.add(rows_, tukey * sigma);
  const double independent = parameters_.correlation / (sigma * sigma);
  const Eigen::Matrix<double, Fit::others, 1> shared = fit.A.col(0).tail<Fit::others>();
  const Eigen::Matrix<double, Fit::others, Fit::others> rest =
      fit.A.bottomRightCorner<Fit::others, Fit::others>();
  const double information = independent * (fit.A(0, 0) - shared.dot(rest.llt().solve(shared)));
  if (!(information > least_information)) return;
  const double sd = parameters_.sd_shading_pair;
  const double counts = 1.0 / (1.0 / information + sd * sd);
  const double faded = 1.0 - 1.0 / parameters_.shading_memory;
  sum_ = faded * sum_ + counts * (rectification.shading() + fit.solution[0]);
  information_ = faded * information_ + counts;
  ++pairs_;
}

}  // namespace ipm_mapping::sweep
