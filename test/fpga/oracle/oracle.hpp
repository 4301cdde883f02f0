#pragma once
// A second implementation of the FPGA contract (docs/fpga_contract.md), kept apart from the twin:
// it shares no code, no constant and no type with it. It is written to be read beside the rules,
// one function a rule, on whole images and 128-bit integers, without a thought for speed.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace oracle {

/// The entries of params.txt (rule 18). The defaults make an ideal camera that does not move.
struct Params {
  int width = 640, height = 480;
  int h11 = 2048, h12 = 0, h13 = 0;
  int h21 = 0, h22 = 2048, h23 = 0;
  int h31 = 0, h32 = 0, h33 = 128;
  int horizon_a = 0, horizon_b = 0, horizon_c = 128, use_horizon = 1;
  int fx = 64 * 500, fy = 64 * 500, cx = 64 * 320, cy = 64 * 240;
  int k1 = 0, k2 = 0, k3 = 0, r2_max = 16777215;
  int focus_u = 320, focus_v = 1400;
  int threshold_in = 255, min_threshold = 6;
  int score_min = 4, min_height = 5, valley_threshold = 1, bearing_tolerance = 1;
  int undistort_current = 1, paper_order = 0, method = 1, single_bin_peaks = 0;
  int free_space_rule = 0, memory_rows = 819;
};

/// One frame: parameters and two raw images, row-major, width*height bytes each.
struct Inputs {
  Params params;
  std::vector<uint8_t> reference, current;
};

/// Counters in the order of overflow.txt.
enum Counter {
  Xn,
  Yn,
  XnCurrent,
  YnCurrent,
  ReadWrite,
  BeamD,
  BeamSlope,
  BearSaturated,
  ContactS,
  ContactH,
  ContactScore,
  A1,
  A2,
  PeaksDropped,
  CounterCount
};
extern const std::array<const char*, CounterCount> counter_names;

/// Branches that a set of test images should have taken; counted, never compared.
enum Event {
  DepthNotPositive,
  AboveHorizon,
  LeavesTwelveSix,
  BeyondTurningRadius,
  OutsideReference,
  NoCurrent,
  ThresholdKept,
  OtsuTie,
  FocusAbove,
  LineEndsAtFocus,
  LineLeavesImage,
  WidthGrows,
  ContactAtLineEnd,
  ContactAtBackground,
  ContactReplaced,
  TooLow,
  TooThin,
  ScoreTooSmall,
  Plateau,
  PlateauRefused,
  NegativeDifference,
  ValleyTie,
  SameObstacle,
  Separate,
  ContactBetweenPeaks,
  ContactOutOfTolerance,
  TieInV,
  TieInDistance,
  NoCandidate,
  EventCount
};
extern const std::array<const char*, EventCount> event_names;

struct Contact {
  int flag = 0;
  uint32_t word = 0;
  bool operator==(const Contact& other) const { return flag == other.flag && word == other.word; }
};

/// Every wire and counter that rule 18 names. Images are row-major.
struct Wires {
  int width = 0, height = 0;
  std::vector<uint16_t> difference, gaussian;
  std::vector<uint8_t> mask, eroded;
  std::vector<int64_t> histogram;
  int threshold_out = 0;
  std::vector<int> bear;
  std::vector<Contact> cor;
  std::vector<uint32_t> peaks, selected, fifo;
  std::array<int64_t, CounterCount> overflow{};
  std::array<int64_t, EventCount> events{};
};

/// Computes one frame. The inputs must have passed checkRanges (vectors.hpp).
/// \throws std::overflow_error where an intermediate leaves int64 (the contract says none can).
Wires run(const Inputs& inputs);

}  // namespace oracle
