#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/plain_edge.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// A straight line on the floor as the polar grid sees it,
///   r = a cos(azimuth) + b sin(azimuth),
/// by least squares over 1 - (a cos + b sin) / r: every row counts the same.
class FloorLine {
 public:
  void add(const Eigen::Vector2d& direction, double r);
  [[nodiscard]] double r(const Eigen::Vector2d& direction) const { return line_.dot(direction); }

 private:
  double xx_ = 0.0, xy_ = 0.0, yy_ = 0.0, x_ = 0.0, y_ = 0.0;
  Eigen::Vector2d line_ = Eigen::Vector2d::Zero();
};

/// A plain face gives no parallax: it is found at its ends and at patches. But it is straight at
/// the foot, and its foot is an edge of the image. A run of contacts on one straight line is
/// continued from both its ends, beam by beam, by at most `foot_reach` of its length. A beam
/// without a contact gets one where, within `foot_window` of the line,
///   sign g is the run's and foot_share < g / g_run < 1 / foot_share,
/// g the change of the beam's mean grey level along the line, g_run what it was along the edge so
/// far, unless the floor goes on behind the edge (PlainEdge) or what lies in front is not floor.
/// The walk ends at a contact of something else. Such a contact scores `foot_score` of the run's
/// lowest, is as high as the run's lowest, and as sure of its range as a flat maximum.
class StraightFoot {
 public:
  void configure(const VerticalSweep& sweep, double height, const SelectionParameters& selection,
                 const StraightFootParameters& parameters);

  /// Fills choices of beams that have none.
  void complete(const CurrentView& current, const SweepReference* references, int count,
                VerticalSweep& sweep, std::vector<BeamChoice>& choices);

 private:
  /// The frame at hand.
  struct Scene {
    const CurrentView& current;
    const SweepReference* references;
    int count;
    VerticalSweep& sweep;
    const std::vector<BeamChoice>& choices;
  };
  /// Contacts on one line.
  struct Run {
    FloorLine line;
    float contrast = 0.0F;  ///< signed mean, grey levels a row
    float score = 0.0F;     ///< the lowest
    int support = 0;        ///< rows, the lowest
    double length = 0.0;    ///< metres
  };
  bool collect(const Scene& scene, int first, Run& run);
  bool measure(const Scene& scene, Run& run) const;
  void walk(const Scene& scene, const Run& run, int side);
  BeamChoice footAt(const Scene& scene, const Run& run, int beam, double expected,
                    float contrast) const;
  bool mayStand(const Scene& scene, int beam, int candidate) const;
  bool floorInFront(const Scene& scene, int beam, int row) const;
  [[nodiscard]] double candidateOf(double r) const;
  [[nodiscard]] Eigen::Vector2d point(int beam, double r) const;

  SelectionParameters selection_;
  StraightFootParameters parameters_;
  PlainEdge plain_edge_;
  double height_ = 1.0, candidates_per_log_ = 1.0, first_r_ = 1.0;
  std::vector<Eigen::Vector2d> direction_;  // of every beam
  std::vector<int> run_;                    // beams of the run at hand
  std::vector<int> contacts_behind_;        // of the run that continued_ is by
  std::vector<BeamChoice> continued_;
};

}  // namespace ipm_mapping::sweep
