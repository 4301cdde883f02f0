// Rules 11 to 15: beam, contacts, peaks, selection.

#include <algorithm>
#include <cstdlib>
#include <tuple>

#include "rules.hpp"

namespace oracle {
namespace {

constexpr Width beam_error{19, true};
constexpr Width bear_width{8, false};
constexpr Width score_width{10, true};
constexpr Width height_width{9, false};
constexpr Width surface_width{13, false};
constexpr Width a1_width{15, false};
constexpr Width a2_width{14, false};

int pixelOrZero(const Params& p, const std::vector<uint8_t>& image, int64_t u, int v) {
  if (u < 0 || u >= p.width || v < 0 || v >= p.height) return 0;
  return image[static_cast<size_t>(v * p.width + u)];
}

}  // namespace

/// Rule 11: the pixels that line i tests, in order.
Line beamLine(const Params& p, int i, Wires& w) {
  const int u0 = 8 * i + 4;
  const int to_focus = p.focus_u - u0;
  const Int du = std::abs(to_focus), dv = std::abs(p.focus_v);
  int s = (to_focus > 0) - (to_focus < 0);
  if (p.focus_v < 0) s = -s;
  if (p.focus_v < 0) ++w.events[FocusAbove];
  if (du > dv) ++w.overflow[BeamSlope];
  const bool ends_at_focus = 0 < p.focus_v && p.focus_v < p.height;
  const int last_row = ends_at_focus ? p.focus_v : p.height - 1;
  if (ends_at_focus) ++w.events[LineEndsAtFocus];

  Line line;
  int64_t u = u0;
  Int d = writeWire(2 * du - dv, beam_error, w.overflow[BeamD]);
  for (int v = 0; v <= last_row; ++v) {
    line.push_back(LinePixel{u, v});
    if (d > 0) {
      u += s;
      d = writeWire(d + 2 * du - 2 * dv, beam_error, w.overflow[BeamD]);
    } else {
      d = writeWire(d + 2 * du, beam_error, w.overflow[BeamD]);
    }
  }
  if (line.back().u < 0 || line.back().u >= p.width) ++w.events[LineLeavesImage];
  return line;
}

/// Rule 11: Bear of one line.
int bearing(const Params& p, const std::vector<uint8_t>& eroded, const Line& line, Wires& w) {
  Int bear = 0;
  for (const LinePixel& at : line) {
    if (pixelOrZero(p, eroded, at.u, at.v) == 1) {
      bear = writeWire(bear + 1, bear_width, w.overflow[BearSaturated]);
    }
  }
  return static_cast<int>(bear);
}

namespace {

/// Rule 12: the registers of one line; a value-initialised one is the reset state.
struct Machine {
  Int b = 11, s = 0, h = 0, score = 0;
  int64_t u = 0;
  int v = 0;

  void narrower(Int a, const LinePixel& at, Wires& w) {
    b = a;
    s = writeWire(s + a, surface_width, w.overflow[ContactS]);
    h = writeWire(h + 1, height_width, w.overflow[ContactH]);
    score = writeWire(score + 1, score_width, w.overflow[ContactScore]);
    u = at.u;
    v = at.v;
  }

  void wider(int method, Wires& w) {
    ++w.events[WidthGrows];
    b = 11;
    if (method == 1) {
      score = writeWire(score - 1, score_width, w.overflow[ContactScore]);
    } else {
      score = s = h = 0;
    }
  }

  bool isContact(const Params& p, Wires& w) const {
    const bool scored = score > p.score_min, wide = s > 4 * h, high = h >= p.min_height;
    if (h > 0 && !scored && wide && high) ++w.events[ScoreTooSmall];
    if (scored && !wide && high) ++w.events[TooThin];
    if (scored && wide && !high) ++w.events[TooLow];
    return scored && wide && high;
  }

  Contact word(int i) const {
    return Contact{1, static_cast<uint32_t>(i << 19 | static_cast<int>(u) << 9 | v)};
  }
};

int windowSum(const Params& p, const std::vector<uint8_t>& eroded, const LinePixel& at) {
  int sum = 0;
  for (int k = -5; k <= 5; ++k) sum += pixelOrZero(p, eroded, at.u + k, at.v);
  return sum;
}

}  // namespace

/// Rule 12: the last contact of one line.
Contact contact(const Params& p, const std::vector<uint8_t>& eroded, const Line& line, int i,
                Wires& w) {
  Contact found;
  Machine m;
  for (const LinePixel& at : line) {
    if (pixelOrZero(p, eroded, at.u, at.v) == 1) {
      const int a = windowSum(p, eroded, at);
      if (a <= m.b) {
        m.narrower(a, at, w);
      } else {
        m.wider(p.method, w);
      }
      continue;
    }
    if (m.isContact(p, w)) {
      ++w.events[found.flag == 1 ? ContactReplaced : ContactAtBackground];
      found = m.word(i);
    }
    m = Machine{};
  }
  if (m.isContact(p, w)) {
    ++w.events[ContactAtLineEnd];
    found = m.word(i);
  }
  return found;
}

namespace {

/// Rule 14: bearings of all peaks, in rising order.
std::vector<int> peakBearings(const Params& p, const std::vector<int>& bear, Wires& w) {
  const auto value = [&](int i) { return i < 0 || i > 79 ? 0 : bear[static_cast<size_t>(i)]; };
  std::vector<int> found;
  for (int first = 0; first < 80; ++first) {
    if (value(first) == 0 || value(first - 1) == value(first)) continue;
    int last = first;
    while (last < 79 && value(last + 1) == value(first)) ++last;
    if (value(first - 1) >= value(first) || value(last + 1) >= value(first)) continue;
    if (last > first) ++w.events[p.single_bin_peaks == 1 ? PlateauRefused : Plateau];
    if (p.single_bin_peaks == 1 && last > first) continue;
    found.push_back((first + last) / 2);
  }
  return found;
}

/// Rule 14: area under the histogram and of the valley between two neighbouring peaks.
bool separate(const Params& p, const std::vector<int>& bear, int i1, int i2, Wires& w) {
  const int step = (i2 - i1) / 2;
  Int under = 0, valley = 0;
  const auto add = [&](int j, int peak) {
    const int below = bear[static_cast<size_t>(peak)] - bear[static_cast<size_t>(j)];
    if (below < 0) ++w.events[NegativeDifference];
    under += bear[static_cast<size_t>(j)];
    valley += std::max(0, below);
  };
  for (int j = i1; j <= i1 + step; ++j) add(j, i1);
  for (int j = i2 - step; j <= i2; ++j) add(j, i2);
  const Int a1 = writeWire(under, a1_width, w.overflow[A1]);
  const Int a2 = writeWire(valley, a2_width, w.overflow[A2]);
  const Int product = a2 * p.valley_threshold;
  if (product == a1) ++w.events[ValleyTie];
  return p.free_space_rule == 0 ? product > a1 : a1 > product;
}

}  // namespace

/// Rule 14: the words of at most 32 peaks.
std::vector<uint32_t> peaks(const Params& p, const std::vector<int>& bear, Wires& w) {
  std::vector<int> bearings = peakBearings(p, bear, w);
  while (bearings.size() > 32) {
    bearings.pop_back();
    ++w.overflow[PeaksDropped];
  }
  std::vector<uint32_t> words;
  for (size_t k = 0; k < bearings.size(); ++k) {
    const bool flag = k == 0 || separate(p, bear, bearings[k - 1], bearings[k], w);
    if (k > 0) ++w.events[flag ? Separate : SameObstacle];
    const auto amplitude = static_cast<uint32_t>(bear[static_cast<size_t>(bearings[k])]);
    words.push_back((flag ? 1U << 15 : 0U) | static_cast<uint32_t>(bearings[k]) << 8 | amplitude);
  }
  return words;
}

namespace {

/// Rule 15: a contact with the peak it serves.
struct Candidate {
  int obstacle, v, distance, bearing;
  uint32_t word;
  /// Largest v, then least distance, then lower bearing.
  bool operator<(const Candidate& o) const {
    return std::make_tuple(-v, distance, bearing) < std::make_tuple(-o.v, o.distance, o.bearing);
  }
};

int bearingOf(uint32_t peak_word) { return static_cast<int>(peak_word >> 8 & 127U); }

Candidate serveNearestPeak(const std::vector<uint32_t>& peaks, const Contact& contact, Wires& w) {
  Candidate best{0, static_cast<int>(contact.word & 511U), 1000,
                 static_cast<int>(contact.word >> 19), contact.word & 0x7ffffU};
  int obstacle = -1;
  for (const uint32_t peak : peaks) {
    obstacle += static_cast<int>(peak >> 15);
    const int distance = std::abs(bearingOf(peak) - best.bearing);
    if (distance == best.distance) ++w.events[ContactBetweenPeaks];
    if (distance >= best.distance) continue;
    best.distance = distance;
    best.obstacle = obstacle;
  }
  return best;
}

void noteTies(const std::vector<Candidate>& sorted, Wires& w) {
  if (sorted.size() < 2 || sorted[0].v != sorted[1].v) return;
  ++w.events[sorted[0].distance == sorted[1].distance ? TieInDistance : TieInV];
}

}  // namespace

/// Rule 15: one word an obstacle, in bearing order.
std::vector<uint32_t> select(const Params& p, const std::vector<uint32_t>& peaks,
                             const std::vector<Contact>& cor, Wires& w) {
  std::vector<std::vector<Candidate>> obstacles;
  for (const uint32_t peak : peaks) {
    if ((peak >> 15) == 1) obstacles.emplace_back();
  }
  for (const Contact& contact : cor) {
    if (contact.flag == 0 || peaks.empty()) continue;
    const Candidate candidate = serveNearestPeak(peaks, contact, w);
    if (candidate.distance <= p.bearing_tolerance) {
      obstacles[static_cast<size_t>(candidate.obstacle)].push_back(candidate);
    } else {
      ++w.events[ContactOutOfTolerance];
    }
  }
  std::vector<uint32_t> words;
  for (std::vector<Candidate>& candidates : obstacles) {
    std::sort(candidates.begin(), candidates.end());
    noteTies(candidates, w);
    if (!candidates.empty()) words.push_back(candidates.front().word);
    if (candidates.empty()) ++w.events[NoCandidate];
  }
  return words;
}

}  // namespace oracle
