#pragma once

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping {

/// How the float chain and the FPGA model are brought together and shown.
struct ComparisonParameters {
  int queue = 32;
  int waiting_frames = 32;
  int gain = 4;
  double contact_size = 10.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("queue", self.queue, Unit{"messages"}, Range{1, 1000},
          "messages of a topic that may wait; more are dropped, oldest first");
    field("waiting_frames", self.waiting_frames, Unit{"frames"}, Range{1, 1000},
          "frames that may wait for the slower side; more are dropped, oldest first");
    field("gain", self.gain, Unit{""}, Range{1, 255},
          "grey levels of difference are multiplied with this in the pictures");
    field("contact_size", self.contact_size, Unit{"px"}, Range{1.0, 50.0},
          "radius of a contact's mark in the pictures");
  }
};

}  // namespace ipm_mapping
