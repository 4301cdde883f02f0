#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/sweep/foot_edge.hpp"

namespace ipm_mapping::sweep {

/// A face that showed itself a moment ago still stands there, also where this frame's parallax does
/// not show it: it has come to the side of the view, or its texture is seen too obliquely. Contacts
/// of the last `foot_memory` seconds are carried along by the floor's motion; a beam without a
/// contact gets one where FootEdge finds the remembered foot's edge near its place. Only contacts
/// that a frame found by itself are remembered: what was found by memory does not feed it. What
/// StraightFoot found has to be found there twice: one guess does not carry another. A doubtful
/// contact carries none.
class RememberedFoot {
 public:
  void configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                 const FootParameters& parameters);
  void reset() { known_.clear(); }

  /// Fills choices of beams that have none, and remembers those that had one before if this is
  /// `new_evidence`. Azimuths count from the camera's foot; `T_floor_foot` is its pose by the
  /// floor's own motion; `seconds` count up, but not while the robot stands.
  void complete(const ComparedFrame& frame, const SE2& T_floor_foot, double seconds,
                bool new_evidence, std::vector<BeamChoice>& choices);

 private:
  struct Known {
    Eigen::Vector2d p_floor;
    double seconds = 0.0;
    bool sure = false;  ///< seen by parallax, or by its edge more than once
    KnownFoot foot;
  };
  /// Where one beam may see a known foot.
  struct Place {
    double distance = 0.0;  ///< metres from the camera's foot; 0: nothing known
    bool sure = false;
    KnownFoot foot;
  };
  void forget(double seconds);
  void assign(const SE2& T_foot_floor);
  [[nodiscard]] bool knownAt(int beam, const BeamChoice& choice) const;
  void remember(const ComparedFrame& frame, const SE2& T_floor_foot, double seconds,
                const std::vector<BeamChoice>& choices);

  FootParameters parameters_;
  FootEdge edge_;
  ScoreGrid grid_;
  std::vector<Known> known_;   // oldest first
  std::vector<Place> newest_;  // of every beam
};

}  // namespace ipm_mapping::sweep
