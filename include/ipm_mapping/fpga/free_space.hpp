#pragma once
// Twin of the free space module: peaks of the polar histogram and the valleys between them
// (the source, §6.9, algorithm 1; rule 14).

#include <array>
#include <cstdint>

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/fpga/frame_parameters.hpp"
#include "ipm_mapping/fpga/overflow.hpp"
#include "ipm_mapping/fpga/polar_histogram.hpp"

namespace ipm_mapping::fpga {

/// Up to 32 words; the first size of them are in use.
template <class Word>
struct WordList {
  std::array<Word, max_peaks> words{};
  int size = 0;

  void clear() { size = 0; }
  [[nodiscard]] bool full() const { return size == max_peaks; }
  void push(Word word) { words[static_cast<std::size_t>(size++)] = word; }
  const Word& operator[](int i) const { return words[static_cast<std::size_t>(i)]; }
  const Word* begin() const { return words.data(); }
  const Word* end() const { return words.data() + size; }
  bool operator==(const WordList& o) const {
    if (size != o.size) return false;
    for (int i = 0; i < size; ++i) {
      if ((*this)[i] != o[i]) return false;
    }
    return true;
  }
};

/// peakWord()s in rising bearing.
using Peaks = WordList<std::uint16_t>;

/// Areas between two peaks at bearings i1 < i2 (figure 3.10), each half measured from its peak.
struct Valley {
  formats::HistogramArea under;  ///< A1: under the histogram
  formats::ValleyArea below;     ///< A2: between the histogram and the peaks
};
[[nodiscard]] Valley valleyBetween(const PolarHistogram& bear, int i1, int i2,
                                   OverflowCounters& counters);

/// Whether two peaks belong to two obstacles.
[[nodiscard]] bool separate(const Valley& valley, const FrameParameters& p);

void freeSpace(const PolarHistogram& bear, const FrameParameters& p, Peaks& peaks,
               OverflowCounters& counters);

}  // namespace ipm_mapping::fpga
