#include "ipm_mapping/sweep/floor_pair.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "ipm_mapping/sweep/floor_sample.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double gain_scale = 100.0;  // keeps the normal equations well conditioned
constexpr double least_spread = 1.0, most_spread = 4.0;  // grey levels
constexpr double tukey = 2.5;
constexpr double median_to_sigma = 1.48;
constexpr double converged = 2e-5;  // radians, log height, metres, seconds
constexpr int margin = 3;           // rows that a sample keeps from the edge of the view
constexpr double certainty = 1e12;  // information of what shall not move

constexpr int shared_unknowns = CalibrationIndex::count;
/// Where the unknowns of a pixel's residual stand among all: pitch, roll, yaw, log height, then
/// motion and sway, readout time, then gain and offset.
constexpr std::array<int, 12> place_of{0,
                                       1,
                                       2,
                                       3,
                                       shared_unknowns,
                                       shared_unknowns + 1,
                                       shared_unknowns + 2,
                                       shared_unknowns + 3,
                                       shared_unknowns + 4,
                                       CalibrationIndex::ReadoutTime,
                                       shared_unknowns + 5,
                                       shared_unknowns + 6};

}  // namespace

CalibrationVector CalibrationInformation::mean() const { return information.llt().solve(vector); }
CalibrationMatrix CalibrationInformation::covariance() const {
  return information.llt().solve(CalibrationMatrix::Identity());
}
CalibrationInformation CalibrationInformation::certainly(const CalibrationVector& state) {
  return {certainty * CalibrationMatrix::Identity(), certainty * state};
}

void FloorPair::configure(const CylindricalRectification& rectification,
                          const std::vector<RowRange>& rows, const StatedCamera& stated,
                          const CalibrationVector& rectified_with,
                          const CalibrationParameters& parameters,
                          const MotionRefinementParameters& noise) {
  const PolarGrid& grid = rectification.grid();
  grid_ = grid;
  rows_ = rows;
  rectification_ = &rectification;
  stated_ = stated;
  rectified_with_ = rectified_with;
  parameters_ = parameters;
  noise_ = noise;
  points_.clear();
  first_row_ = std::max(0, static_cast<int>(grid.row(grid.height * parameters.farthest)));
  for (int line = 1; line < grid.lines - 1; line += parameters.line_step) {
    const RowRange range = rows[static_cast<std::size_t>(line)];
    for (int row = std::max(first_row_, range.begin); row < range.end; row += parameters.row_step)
      points_.push_back({static_cast<float>(row), static_cast<float>(line), direction(row, line)});
  }
  deviations_.reserve(points_.size());
}

FloorWarp FloorPair::warp(const FramePair& pair, const CalibrationVector& state, const SE2& motion,
                          const Eigen::Vector2d& sway) const {
  const double readout = parameters_.readout_time + state[CalibrationIndex::ReadoutTime];
  const ReadoutOfPair rolling{pair.current.velocity, pair.reference.velocity,
                              readout - pair.current.readout, readout - pair.reference.readout};
  return {grid_, stated_, state, rectified_with_, motion, sway, rolling};
}

/// When a row of the reference was read depends on the row, which hardly depends on that.
bool FloorPair::place(const FloorWarp& floor, const FloorPoint& point,
                      FloorWarp::Position& at) const {
  const double here = readTime(point.row, point.line);
  if (!floor(point.direction, at, {here, here}) || !inView(at)) return false;
  if (!floor.rolling()) return true;
  return floor(point.direction, at, {here, readTime(at.row, at.line)}) && inView(at);
}

bool FloorPair::inView(const FloorWarp::Position& at) const {
  if (!(at.line >= 1.0 && at.line < grid_.lines - 3.0)) return false;
  const auto line = static_cast<std::size_t>(at.line);
  const RowRange range = intersection(rows_[line], rows_[line + 1]);
  return at.row >= range.begin + margin && at.row < range.end - margin - 1;
}

void FloorPair::PixelSums::add(double weight, double residual, const Seen& J) {
  ++fitting;
  b.noalias() += (weight * residual) * J;
  A.triangularView<Eigen::Lower>() += (weight * J) * J.transpose();
}

double FloorPair::PixelSums::likeness() const {
  const double power = cc * rr;
  return power > 0.0 ? cr / std::sqrt(power) : 0.0;
}

void FloorPair::PixelSums::addTo(Normal& normal, double information) const {
  for (std::size_t r = 0; r < place_of.size(); ++r) {
    const auto i = static_cast<int>(r);
    normal.b[place_of[r]] += information * b[i];
    for (std::size_t c = 0; c < place_of.size(); ++c) {
      const auto k = static_cast<int>(c);
      normal.A(place_of[r], place_of[c]) += information * A(std::max(i, k), std::min(i, k));
    }
  }
}

FloorPair::PixelSums FloorPair::addPixels(const FramePair& pair, const Guess& guess, double limit) {
  const FloorWarp floor = warp(pair, guess.state, guess.motion, guess.sway);
  const double gain = guess.photometric.gain, offset = guess.photometric.offset;
  PixelSums sums;
  deviations_.clear();
  for (const FloorPoint& point : points_) {
    FloorWarp::Position at;
    if (!place(floor, point, at)) continue;
    const GreyPatch patch = greyPatch(pair.reference.image, at.row, at.line);
    const auto row = static_cast<float>(at.row), line = static_cast<float>(at.line);
    const double r = patch.value - static_cast<double>(pair.reference.mean.at(row, line));
    const double c =
        pair.current.image.at(static_cast<int>(point.row), static_cast<int>(point.line)) -
        static_cast<double>(pair.current.mean.at(point.row, point.line));
    const double e = c - (gain * r + offset), w = tukeyWeight(e, limit);
    deviations_.push_back(static_cast<float>(std::abs(e)));
    if (w == 0.0) continue;
    Seen J;
    J << gain * (floor.slopes(at).transpose() * Eigen::Vector2d(patch.by_row, patch.by_line)),
        r / gain_scale, 1.0;
    sums.add(w, e, J);
    sums.cc += w * c * c;
    sums.cr += w * c * r;
    sums.rr += w * r * r;
  }
  return sums;
}

/// Robust standard deviation of the residual, within sane bounds.
double FloorPair::spread() {
  const auto middle = deviations_.begin() + static_cast<std::ptrdiff_t>(deviations_.size() / 2);
  if (middle == deviations_.end()) return most_spread;
  std::nth_element(deviations_.begin(), middle, deviations_.end());
  return std::clamp(median_to_sigma * static_cast<double>(*middle), least_spread, most_spread);
}

void FloorPair::addOdometry(const FramePair& pair, const Guess& guess, Normal& normal) const {
  const CalibrationParameters& p = parameters_;
  const SE2 odometry = pair.odometry(guess.state[CalibrationIndex::TimeOffset]);
  const double d = odometry.distance();
  const Eigen::Vector3d sd(
      p.sd_forward * d + noise_.sd_forward_floor, p.sd_sideways * d + noise_.sd_sideways_floor,
      p.sd_turn * d + noise_.sd_turn_share * std::abs(odometry.theta) + noise_.sd_turn_floor);
  const Eigen::Vector3d weight = sd.cwiseAbs2().cwiseInverse();
  const SE2 expected = corrected(odometry, pair.seconds(), guess.state);
  const Eigen::Vector3d e(expected.x - guess.motion.x, expected.y - guess.motion.y,
                          expected.theta - guess.motion.theta);
  Eigen::Matrix<double, 3, all> J = Eigen::Matrix<double, 3, all>::Zero();
  J.block<3, 3>(0, CalibrationIndex::LogScale) =
      -correctionSlopes(odometry, pair.seconds(), guess.state);
  // a place and a scale that are a few per cent off change little about how time moves things
  J.col(CalibrationIndex::TimeOffset) =
      -MovingPair(odometry, pair.current.velocity, pair.reference.velocity).after(1.0, 1.0);
  J.block<3, 3>(0, shared).setIdentity();
  normal.A += J.transpose() * weight.asDiagonal() * J;
  normal.b += J.transpose() * weight.cwiseProduct(e);
}

/// Small sway and unchanged brightness.
void FloorPair::addRest(const Guess& guess, Normal& normal) const {
  Eigen::Vector4d sd, rest;
  sd << parameters_.sd_sway, parameters_.sd_sway, noise_.sd_gain * gain_scale, noise_.sd_offset;
  rest << -guess.sway, gain_scale * (1.0 - guess.photometric.gain), -guess.photometric.offset;
  const Eigen::Vector4d weight = sd.cwiseAbs2().cwiseInverse();
  normal.A.diagonal().tail<4>() += weight;
  normal.b.tail<4>() += weight.cwiseProduct(rest);
}

CalibrationInformation FloorPair::marginal(const Normal& normal, const CalibrationVector& state) {
  using Own = Eigen::Matrix<double, own, own>;
  const Eigen::LLT<Own> solver(Own(normal.A.bottomRightCorner<own, own>()));
  const Eigen::Matrix<double, own, shared> mixed = normal.A.bottomLeftCorner<own, shared>();
  const Eigen::Matrix<double, own, 1> inner = normal.b.tail<own>();
  CalibrationInformation result;
  result.information = normal.A.topLeftCorner<shared, shared>();
  result.information -= mixed.transpose() * solver.solve(mixed);
  result.vector = normal.b.head<shared>() - mixed.transpose() * solver.solve(inner) +
                  result.information * state;
  return result;
}

void FloorPair::Guess::add(const All& delta) {
  state += delta.head<shared>();
  motion.x += delta[shared];
  motion.y += delta[shared + 1];
  motion.theta += delta[shared + 2];
  sway += delta.segment<2>(shared + 3);
  photometric.gain += delta[shared + 5] / gain_scale;
  photometric.offset += delta[shared + 6];
}

PairEvidence FloorPair::evaluate(const FramePair& pair, const CalibrationInformation& known,
                                 const CalibrationVector& start) {
  PairEvidence evidence;
  Guess guess;
  guess.state = start;
  guess.motion =
      corrected(pair.odometry(start[CalibrationIndex::TimeOffset]), pair.seconds(), start);
  guess.sigma = most_spread;
  for (int i = 0; i < parameters_.iterations; ++i) {
    const double anneal = noise_.first_spread * std::pow(0.5, i);
    const PixelSums sums = addPixels(pair, guess, tukey * std::max(guess.sigma, anneal));
    evidence.samples = sums.fitting;
    if (evidence.samples < parameters_.min_samples) return evidence;
    guess.sigma = spread();
    evidence.likeness = sums.likeness();
    Normal normal;
    sums.addTo(normal, parameters_.correlation / (guess.sigma * guess.sigma));
    addOdometry(pair, guess, normal);
    addRest(guess, normal);
    evidence.about = marginal(normal, guess.state);
    normal.A.topLeftCorner<shared, shared>() += known.information;
    normal.b.head<shared>() += known.vector - known.information * guess.state;
    const All delta = normal.A.llt().solve(normal.b);
    guess.add(delta);
    if (anneal < most_spread && delta.head<shared + 5>().cwiseAbs().maxCoeff() < converged) break;
  }
  evidence.used = evidence.likeness >= parameters_.min_likeness;
  evidence.state = guess.state;
  evidence.motion = guess.motion;
  evidence.sway = guess.sway;
  evidence.sigma = guess.sigma;
  return evidence;
}

}  // namespace ipm_mapping::sweep
