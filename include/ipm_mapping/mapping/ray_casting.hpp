#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdlib>

namespace ipm_mapping {

/// A cell of a square grid; cell (x, y) covers [x, x + 1) x [y, y + 1) in units of its side.
struct Cell {
  int x = 0;
  int y = 0;
  [[nodiscard]] bool operator==(const Cell& o) const { return x == o.x && y == o.y; }
};

/// The cell that holds a point given in units of the cell's side.
[[nodiscard]] inline Cell cellOf(const Eigen::Vector2d& point) {
  return {static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y()))};
}

namespace ray_detail {

/// One axis of the walk: where it stands, and when the segment enters the next cell.
struct Axis {
  double start;
  double extent;
  int cell;
  int last;
  int step;

  Axis(double from, double to, int first, int end)
      : start(from), extent(to - from), cell(first), last(end), step(end < first ? -1 : 1) {}
  [[nodiscard]] bool arrived() const { return cell == last; }
  /// Share of the segment at which it leaves the present cell. From the cell's index instead of by
  /// summing up, so that no rounding accumulates over long rays.
  [[nodiscard]] double leaves() const {
    return (static_cast<double>(step > 0 ? cell + 1 : cell) - start) / extent;
  }
};

}  // namespace ray_detail

/// Calls `visit(Cell)` for every cell that the segment crosses, in order, both ends included
/// (Amanatides and Woo, 1987). Consecutive cells share a side; through a corner the walk takes the
/// x step first. Points in units of the cell's side, finite, within the range of int.
template <class Visit>
void forEachCellOnSegment(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Visit&& visit) {
  const Cell first = cellOf(from), end = cellOf(to);
  ray_detail::Axis x(from.x(), to.x(), first.x, end.x);
  ray_detail::Axis y(from.y(), to.y(), first.y, end.y);
  visit(first);
  while (!x.arrived() || !y.arrived()) {
    ray_detail::Axis& axis = y.arrived() || (!x.arrived() && x.leaves() <= y.leaves()) ? x : y;
    axis.cell += axis.step;
    visit(Cell{x.cell, y.cell});
  }
}

}  // namespace ipm_mapping
