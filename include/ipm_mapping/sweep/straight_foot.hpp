#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/foot_edge.hpp"
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
/// continued from both its ends, beam by beam, by at most `foot_reach` of its length: a beam
/// without a contact gets one where FootEdge finds the run's edge near the line, its contrast what
/// it was along the edge so far. The walk ends at a contact of something else. The run's lowest
/// score and support are what is known of the foot; one that is lower than `foot_support`, where
/// the floor behind an edge is told, is not continued: it may stand at the edge of a rug.
class StraightFoot {
 public:
  void configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                 const FootParameters& parameters);

  /// Fills choices of beams that have none.
  void complete(const ComparedFrame& frame, std::vector<BeamChoice>& choices);

 private:
  struct Scene {
    const ComparedFrame& frame;
    const std::vector<BeamChoice>& choices;
  };
  /// Contacts on one line.
  struct Run {
    FloorLine line;
    KnownFoot foot;       ///< mean contrast, the lowest score and support
    double length = 0.0;  ///< metres
  };
  bool collect(const Scene& scene, int first, Run& run);
  bool measure(const Scene& scene, Run& run) const;
  void walk(const Scene& scene, const Run& run, int side);
  [[nodiscard]] Eigen::Vector2d point(int beam, double r) const;

  FootParameters parameters_;
  FootEdge edge_;
  ScoreGrid grid_;
  int least_support_ = 0;                   // rows of every contact of a run
  std::vector<Eigen::Vector2d> direction_;  // of every beam
  std::vector<int> run_;                    // beams of the run at hand
  std::vector<int> contacts_behind_;        // of the run that continued_ is by
  std::vector<BeamChoice> continued_;
};

}  // namespace ipm_mapping::sweep
