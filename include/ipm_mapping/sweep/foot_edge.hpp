#pragma once

#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/plain_edge.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// A frame as the sweep compares it.
struct ComparedFrame {
  const CurrentView& current;
  const SweepReference* references;
  int count;
  VerticalSweep& sweep;
};

/// The foot of a face that is known from elsewhere: from the beams beside, or from frames before.
struct KnownFoot {
  float contrast = 0.0F;  ///< signed, grey levels a row
  float score = 0.0F;
  int support = 0;  ///< rows
};

/// Looks for the foot of a known face where its own parallax does not show it: there is one where,
/// within `foot_window` of where it is expected,
///   sign g is the known foot's and foot_share < g / g_known < 1 / foot_share,
/// g the change of the beam's mean grey level along the line, unless the floor goes on behind the
/// edge (PlainEdge) or what lies in front is not floor. Such a contact scores `foot_score` of the
/// known one, is as high, and as sure of its range as a flat maximum.
class FootEdge {
 public:
  void configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                 const FootParameters& parameters);

  /// A contact of a beam near an expected candidate; none where the edge is not there.
  BeamChoice find(const ComparedFrame& frame, const KnownFoot& known, int beam,
                  double expected) const;
  /// Strongest change within a row of a contact, signed.
  static float contrastAt(const ComparedFrame& frame, int beam, const BeamChoice& choice);
  /// The place between rows where the image changes most around a candidate that is an edge.
  static float sharpest(const ComparedFrame& frame, int beam, int candidate);
  /// Is everything from the near end of the view up to an edge on this sweep row floor in the eyes
  /// of the references?
  bool floorInFront(const ComparedFrame& frame, int beam, int row) const;

 private:
  bool mayStand(const ComparedFrame& frame, int beam, int candidate) const;

  FreeFloorParameters free_floor_;
  FootParameters parameters_;
  PlainEdge plain_edge_;
};

}  // namespace ipm_mapping::sweep
