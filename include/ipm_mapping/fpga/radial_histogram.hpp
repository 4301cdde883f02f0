#pragma once
// Twin of the first architecture's localisation (the source, §3.6, §3.8): polar histogram of the
// bird's-eye view around the mid foot point, peaks as in rule 14, and the distance of each peak
// from its sector's radial histogram.

#include <array>
#include <vector>

#include "ipm_mapping/fpga/birds_eye.hpp"
#include "ipm_mapping/fpga/free_space.hpp"

namespace ipm_mapping::fpga {

namespace formats {
using Radius = Unsigned<10>;  ///< pixels from the focus

using RadialThreshold = Unsigned<8>;  ///< share in 256ths
}  // namespace formats

/// Bins around a peak whose amplitude is at least half the peak's.
struct PeakSector {
  int first = 0;
  int last = 0;
};
[[nodiscard]] PeakSector peakSector(const PolarHistogram& bear, int bearing);

struct FirstArchitectureResults {
  PolarHistogram bear{};
  Peaks peaks;
  /// Radius of each peak's obstacle in pixels of the bird's-eye view; -1: none.
  std::array<int, max_peaks> radius{};
  OverflowCounters overflow;
};

/// Owns its radial bins: no allocation after construction.
class FirstArchitecture {
 public:
  /// `threshold`: share of a radius's seen pixels that makes an obstacle, in 256ths (rule of §3.8).
  explicit FirstArchitecture(int threshold = 128) : threshold_(threshold) {}

  /// `focus`: the mid foot point's pixel. Free-space registers are taken from `p` (rule 14).
  void run(ImageView<const std::uint8_t> birds_eye, FocusWord focus, const FrameParameters& p,
           FirstArchitectureResults& results);

 private:
  static constexpr std::size_t radii = 1 << formats::Radius::width;
  struct Bin {
    int obstacle = 0;
    int seen = 0;
  };

  void countLine(ImageView<const std::uint8_t> birds_eye, FocusWord focus, int line);
  [[nodiscard]] int firstRadius() const;

  int threshold_;
  std::array<Bin, radii> bins_{};
};

/// floor(sqrt(du^2 + dv^2)): the radial bin of a pixel.
[[nodiscard]] int radiusOf(int du, int dv);

}  // namespace ipm_mapping::fpga
