#pragma once

#include <vector>

#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/floor_cost.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// g: half the difference of a beam's mean grey level one sweep row nearer and one row farther.
[[nodiscard]] float edgeContrast(const CurrentView& current, int first_line, int row);

/// The foot of an obstacle is an edge of the image. At the contact itself there is no parallax, so
/// the sweep's score is flat there, and it falls more steeply towards the robot: its maximum lies
/// up to a row too far. Among the candidates around it the edge decides,
///   J(c) = S(c) + edge_score g^2 / (g^2 + edge_contrast^2),
/// g the change of the beam's mean grey level along the line, per sweep row.
class ContactEdge {
 public:
  void configure(const SelectionParameters& parameters);

  /// Moves every contact to the maximum of J and makes `curvature` that of J.
  void refine(const CurrentView& current, const VerticalSweep& sweep, const SweepScores& scores,
              std::vector<BeamChoice>& choices);

 private:
  void refineOne(const CurrentView& current, const VerticalSweep& sweep, const SweepScores& scores,
                 int beam, BeamChoice& choice);

  SelectionParameters parameters_;
  std::vector<float> merit_;  // J in the window
};

}  // namespace ipm_mapping::sweep
