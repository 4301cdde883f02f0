#include "ipm_mapping/sweep/floor_warp.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "ipm_mapping/sweep/foot_motion.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double least_depression = 1e-3;

CalibrationVector swayed(const Eigen::Vector2d& sway) {
  CalibrationVector state = CalibrationVector::Zero();
  state.head<2>() = sway;
  return state;
}

}  // namespace

FloorWarp::FloorWarp(const PolarGrid& grid, const StatedCamera& stated,
                     const CalibrationVector& state, const CalibrationVector& rectified_with,
                     const SE2& motion, const Eigen::Vector2d& sway, const ReadoutOfPair& readout)
    : grid_(grid),
      tilt_(stated.tilt(state)),
      turning_(stated.turning(state)),
      axes_(stated.axes),
      grid_from_true_(stated.tilt(rectified_with) *
                      (stated.tilt(swayed(sway)) * tilt_).transpose()),
      foot_(stated.foot),
      height_(stated.height * std::exp(state[CalibrationIndex::LogHeight])),
      motion_(motion),
      readout_(readout),
      moving_(motion, readout.current, readout.reference) {}

/// The motion between the places from which the two rows were read.
void FloorWarp::moveBetweenRows(const ReadTimes& times, Position& at) const {
  const Eigen::Vector3d d = moving_.after(times.current * readout_.current_seconds,
                                          times.reference * readout_.reference_seconds);
  at.by_readout = moving_.after(times.current, times.reference);
  const FootMotion between({motion_.x + d.x(), motion_.y + d.y(), motion_.theta + d.z()}, foot_);
  at.c = between.c;
  at.s = between.s;
  at.tx = between.tx;
  at.ty = between.ty;
}

bool FloorWarp::operator()(const Eigen::Vector3d& direction, Position& at,
                           const ReadTimes& times) const {
  moveBetweenRows(times, at);
  at.n = tilt_ * direction;
  if (!(at.n.z() < -least_depression)) return false;
  const double scale = -height_ / at.n.z();
  at.v = {scale * (at.c * at.n.x() - at.s * at.n.y()) + at.tx,
          scale * (at.s * at.n.x() + at.c * at.n.y()) + at.ty, -height_};
  at.g = grid_from_true_ * at.v;
  const double across2 = at.g.head<2>().squaredNorm();
  if (!(at.g.z() < 0.0) || across2 == 0.0) return false;
  at.row = (std::log(-at.g.z()) - 0.5 * std::log(across2) - grid_.log_r_far) * grid_.rows_per_log;
  at.line = grid_.line(std::atan2(at.g.y(), at.g.x()));
  return true;
}

/// With w_k the rotation vector of angle k: dn = w_k x n, and the way back turns by -w_k:
///   dv = (R dp, 0) - w_k x v;   d ln r = dg_z / g_z - (g_xy . dg_xy) / |g_xy|^2.
FloorWarp::Slopes FloorWarp::slopes(const Position& at) const {
  const double scale = -height_ / at.n.z();
  const double px = scale * at.n.x(), py = scale * at.n.y();
  Eigen::Matrix<double, 3, count> dv;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d w = turning_.col(k), dn = w.cross(at.n), back = w.cross(at.v);
    const double dx = scale * dn.x() - px * dn.z() / at.n.z();
    const double dy = scale * dn.y() - py * dn.z() / at.n.z();
    dv.col(k) = Eigen::Vector3d(at.c * dx - at.s * dy, at.s * dx + at.c * dy, 0.0) - back;
    if (k < 2) dv.col(SwayPitch + k) = -axes_.col(k).cross(at.v);
  }
  const double X = foot_.x() + px, Y = foot_.y() + py;
  dv.col(LogHeight) << at.v.x() - at.tx, at.v.y() - at.ty, -height_;
  dv.block<3, 2>(0, LogHeight + 1) << 1, 0, 0, 1, 0, 0;
  dv.col(Theta) << -at.s * X - at.c * Y, at.c * X - at.s * Y, 0;
  dv.col(ReadoutTime) = dv.middleCols<3>(FloorWarp::X) * at.by_readout;
  const Eigen::Matrix<double, 3, count> dg = grid_from_true_ * dv;
  const Eigen::Vector2d g = at.g.head<2>();
  const double across2 = g.squaredNorm();
  Slopes slopes;
  slopes.row(0) = grid_.rows_per_log *
                  (dg.row(2) / at.g.z() - (g.x() * dg.row(0) + g.y() * dg.row(1)) / across2);
  slopes.row(1) = -grid_.lines_per_radian / across2 * (g.x() * dg.row(1) - g.y() * dg.row(0));
  return slopes;
}

Eigen::Vector3d statedDirection(const PolarGrid& grid, const StatedCamera& stated,
                                const CalibrationVector& rectified_with, double row, double line) {
  const double azimuth = grid.azimuth(line);
  return stated.tilt(rectified_with).transpose() *
         Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), -grid.r(row));
}

}  // namespace ipm_mapping::sweep
