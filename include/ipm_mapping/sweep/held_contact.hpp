#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/foot_parameters.hpp"
#include "ipm_mapping/sweep/foot_edge.hpp"

namespace ipm_mapping::sweep {

/// What was found at a place again and again and looks there as it did stands there still, though
/// this frame's parallax does not show it. In ln r a face on the floor is as high from near and
/// from far, so its rows are compared as they are: with e the change of a beam's mean grey levels
/// and g those of the last sight, over the rows around the foot,
///   sum (e - mean e)^2 <= hold_change sum (g - mean g)^2.
/// What has gone shows floor instead: where that is of one brightness e = -g.
/// `hold_sights` sights of one place are needed, 0.25 s apart, within `hold_memory` seconds. Floor
/// that is reported free where it was forgets it.
class HeldContact {
 public:
  /// A contact of before in the present view; none where `choice` is none.
  struct Held {
    BeamChoice choice;
    double stamp = 0.0;  ///< of its last sight
  };

  void configure(const VerticalSweep& sweep, const FootParameters& parameters);
  void reset();

  /// What is held, of every beam that has no contact in the answer. The answer's contacts are
  /// remembered, and what it shows to be floor is forgotten, if it is `new_evidence`.
  /// `T_floor_foot` is the pose of the camera's foot by the floor's own motion.
  const std::vector<Held>& follow(const ComparedFrame& frame, const SE2& T_floor_foot,
                                  bool new_evidence, const std::vector<BeamChoice>& choices,
                                  const Obstacles& answer);

 private:
  static constexpr int rows_below = 5, rows_above = 16;  // of a face; the foot's is one below

  /// Mean grey levels of a beam, rows `begin` to `end` - 1 counted from the foot's.
  struct Face {
    int begin = 0, end = 0;
    std::array<float, rows_below + rows_above> grey{};
  };
  struct Sight {
    Eigen::Vector2d p_floor;
    double stamp = 0.0;
    int look = 0;  ///< which one it was seen in
    float score = 0.0F, curvature = 0.0F;
    int support = 0;  ///< rows
    Face face;
  };
  /// What is known of one beam.
  struct Place {
    int newest = -1;  ///< index of the sight
    double candidate = 0.0;
    int sights = 0, last_look = 0;
  };

  void forget(double stamp);
  void assign(const SE2& T_foot_floor, bool new_evidence, const Obstacles& answer);
  void count(Place& place, double candidate, int sight) const;
  [[nodiscard]] Face faceAt(const ComparedFrame& frame, int beam, const BeamChoice& choice) const;
  [[nodiscard]] bool looksAsBefore(const ComparedFrame& frame, int beam, double candidate,
                                   const Face& before) const;
  void remember(const ComparedFrame& frame, const SE2& T_floor_foot,
                const std::vector<BeamChoice>& choices, const Obstacles& answer);

  FootParameters parameters_;
  ScoreGrid grid_;
  int look_ = 0;
  double looked_ = 0.0;        // its stamp
  std::vector<Sight> sights_;  // oldest first
  std::vector<Place> places_;  // of every beam
  std::vector<Held> held_;     // of every beam
};

}  // namespace ipm_mapping::sweep
