#pragma once

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping::sweep {

/// Contacts that this frame's parallax does not show: of plain faces, by the edge at their foot,
/// along a straight one and from frame to frame; and of what looks as it did.
struct FootParameters {
  double foot_reach = 2.0;
  double foot_length = 0.2;
  int foot_beams = 3;
  double foot_tolerance = 1.5;
  int foot_window = 2;
  double foot_contrast = 6.0;
  double foot_share = 0.5;
  double foot_floor_cost = 1.3;
  double foot_support = 0.2;
  double foot_doubt = 10.0;
  double foot_score = 0.5;
  double foot_memory = 3.0;
  int chain_gap = 20;
  double chain_step = 4.0;
  int chain_beams = 6;
  double chain_share = 2.0;
  double chain_score = 8.0;
  int hold_sights = 2;
  double hold_memory = 6.0;
  double hold_change = 0.6;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("foot_reach", self.foot_reach, Unit{""}, Range{0.0, 100.0},
          "a straight run of contacts is continued along the image's edge by this many times its "
          "own length; 0: not");
    field("foot_length", self.foot_length, Unit{"camera heights"}, Range{0.0, 10.0},
          "a shorter run has no direction: it may be a piece of something round");
    field("foot_beams", self.foot_beams, Unit{"beams"}, Range{3, 100},
          "a run of fewer contacts has none either");
    field("foot_tolerance", self.foot_tolerance, Unit{"candidates"}, Range{0.1, 20.0},
          "how far off the line a contact of the run may lie");
    field("foot_window", self.foot_window, Unit{"candidates"}, Range{0, 20},
          "how far off the line the edge is looked for");
    field("foot_contrast", self.foot_contrast, Unit{"grey levels/row"}, Range{0.0, 255.0},
          "a run with a fainter edge is not continued");
    field("foot_share", self.foot_share, Unit{""}, Range{0.01, 1.0},
          "the edge goes on where its contrast is between this share of the run's and the inverse "
          "of it");
    field("foot_floor_cost", self.foot_floor_cost, Unit{"sigma^2"}, Range{0.0, 9.0},
          "no edge is a foot where the floor in front of it costs more over free_window rows");
    field("foot_support", self.foot_support, Unit{"camera heights"}, Range{0.01, 0.9},
          "how far above the edge floor and upright surface are compared");
    field("foot_doubt", self.foot_doubt, Unit{""}, Range{0.0, 1000.0},
          "an upright surface that scores less than minus this there is floor behind a line on the "
          "floor");
    field(
        "foot_score", self.foot_score, Unit{""}, Range{0.0, 1.0},
        "score of a contact that was found by its edge: this share of the lowest of the run, or of "
        "the one it is known by");
    field("foot_memory", self.foot_memory, Unit{"s"}, Range{0.0, 60.0},
          "where a contact was seen this short a time ago, an edge like the one at its foot is a "
          "contact still; 0: not");
    field("chain_gap", self.chain_gap, Unit{"beams"}, Range{0, 1000},
          "an edge that goes on from a contact to another one at most so far away is the foot of "
          "what stands between them; 0: not");
    field("chain_step", self.chain_step, Unit{"candidates"}, Range{0.1, 100.0},
          "such an edge moves by no more from beam to beam");
    field("chain_beams", self.chain_beams, Unit{"beams"}, Range{0, 100},
          "how far to either side beams along an edge are asked together whether something upright "
          "stands there; 0: each for itself");
    field("chain_share", self.chain_share, Unit{""}, Range{0.0, 1000.0},
          "what a single one of them may add to the score at most");
    field("chain_score", self.chain_score, Unit{""}, Range{0.0, 1000.0},
          "score that all of them have to reach");
    field("hold_sights", self.hold_sights, Unit{""}, Range{0, 10},
          "a place where contacts were seen so often, 0.25 s apart, has one as long as it looks as "
          "it did and is not seen to be floor; 0: not");
    field("hold_memory", self.hold_memory, Unit{"s"}, Range{0.5, 30.0},
          "for how long a sight of a place counts for that: at least 0.25 for each of hold_sights");
    field("hold_change", self.hold_change, Unit{""}, Range{0.0, 1.0},
          "it looks as it did where its rows have changed by no more than this share of how much "
          "they differ (variances)");
  }
};

}  // namespace ipm_mapping::sweep
