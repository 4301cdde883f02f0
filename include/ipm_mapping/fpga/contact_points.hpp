#pragma once
// Twin of the contact point extraction, and the localisation module around it
// (the source, §6.8.1.2; rules 11 and 12).

#include <array>
#include <cstdint>

#include "ipm_mapping/fpga/polar_histogram.hpp"

namespace ipm_mapping::fpga {

/// One entry of Cor.
struct ContactEntry {
  bool found = false;
  std::uint32_t word = 0;  ///< contactWord(); 0 where nothing was found

  bool operator==(const ContactEntry& o) const { return found == o.found && word == o.word; }
};
using Contacts = std::array<ContactEntry, line_count>;

enum class TriangleMethod : std::uint8_t { Score = 0, Triangle = 1 };

/// Registers of one line's triangle (eq. 5.6-5.8 and 5.9-5.16).
class ContactMachine {
 public:
  ContactMachine(int line, const FrameParameters& p);

  /// A pixel of the line with the window sum around it.
  void row(bool pixel, int u, int v, int window_sum, OverflowCounters& counters);
  /// The line's end: a triangle that is still open is judged.
  void finish();
  [[nodiscard]] const ContactEntry& contact() const { return contact_; }

 private:
  void narrow(int u, int v, formats::WindowSum a, OverflowCounters& counters);
  void widenOut(OverflowCounters& counters);
  void reset();

  int line_;
  TriangleMethod method_;
  Integer score_min_, min_height_;
  formats::WindowSum smallest_;
  formats::ContactScore score_;
  formats::ContactHeight height_;
  formats::ContactSurface surface_;
  int u_ = 0, v_ = 0;
  ContactEntry contact_;
};

/// Obstacle pixels of a row in the 11-pixel window around u; pixels outside count 0.
[[nodiscard]] int windowSum(ImageView<const std::uint8_t> eroded, int u, int v);

/// The whole localisation module: Bear and Cor of an eroded image.
void localize(ImageView<const std::uint8_t> eroded, const FrameParameters& p, PolarHistogram& bear,
              Contacts& cor, OverflowCounters& counters);

}  // namespace ipm_mapping::fpga
