#pragma once

#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/foot_edge.hpp"

namespace ipm_mapping::sweep {

/// A plain face shows little parallax, but its foot is an edge of the image that goes on from beam
/// to beam. The foot of a beam is its contact, or the nearest edge behind which something may stand
/// (PlainEdge) with floor in front of it (FootEdge). Feet of neighbouring beams, `chain_step`
/// candidates apart at most and with edges of like contrast, are a chain. A beam of a chain without
/// a contact gets one
/// - between two contacts of the chain that are at most `chain_gap` beams apart, or
/// - where the `chain_beams` to either side show together what one does not: a skirting board's
///   upper edge, a corner, a stain that is z high lies ln((h - z) / h) above the foot in each of
///   them, so that gains of rows of upright surfaces add up by how far above the foot they are,
///     max over o of sum over beams of min(sum_{k <= o} w (F - V - prior)(foot - k), `chain_share`)
///   is `chain_score` or more.
class FootChain {
 public:
  void configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                 const FootParameters& parameters);

  /// Fills choices of beams that have none.
  void complete(const ComparedFrame& frame, std::vector<BeamChoice>& choices);

 private:
  struct Foot {
    float candidate = -1.0F;  ///< negative: none
    float contrast = 0.0F;    ///< signed, grey levels a row
    int chain = -1;
    [[nodiscard]] bool any() const { return candidate >= 0.0F; }
  };
  Foot footOf(const ComparedFrame& frame, int beam, const BeamChoice& choice);
  void link();
  void fillGains(const ComparedFrame& frame, int beam);
  [[nodiscard]] int contactBeside(const std::vector<BeamChoice>& choices, int beam, int side) const;
  [[nodiscard]] BeamChoice between(const ComparedFrame& frame,
                                   const std::vector<BeamChoice>& choices, int beam) const;
  [[nodiscard]] BeamChoice together(const ComparedFrame& frame, int beam);

  FootParameters parameters_;
  PlainEdge plain_edge_;
  FootEdge edge_;
  int support_rows_ = 0;
  std::vector<Foot> feet_;
  Image<float> gain_;       // up to a row above the foot x beams
  std::vector<float> sum_;  // of beams
  std::vector<BeamChoice> found_;
};

}  // namespace ipm_mapping::sweep
