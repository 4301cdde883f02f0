#include "oracle.hpp"

#include "rules.hpp"

namespace oracle {

const std::array<const char*, CounterCount> counter_names = {
    "xn",   "yn",        "xn_current", "yn_current",    "read_write", "beam_d", "beam_slope",
    "bear", "contact_s", "contact_h",  "contact_score", "a1",         "a2",     "peaks"};

const std::array<const char*, EventCount> event_names = {"depth not positive",
                                                         "above the horizon",
                                                         "leaves 12.6",
                                                         "beyond the turning radius",
                                                         "outside the reference",
                                                         "no current pixel",
                                                         "threshold kept",
                                                         "tie in Otsu",
                                                         "focus above the image",
                                                         "line ends at the focus",
                                                         "line leaves the image",
                                                         "width grows along the line",
                                                         "contact at the line's end",
                                                         "contact at the first background",
                                                         "contact replaced by a nearer one",
                                                         "triangle too low",
                                                         "triangle too thin",
                                                         "score too small",
                                                         "plateau is a peak",
                                                         "plateau refused",
                                                         "negative difference in A2",
                                                         "A2 th = A1",
                                                         "same obstacle",
                                                         "separate obstacles",
                                                         "contact as near to two peaks",
                                                         "contact out of tolerance",
                                                         "tie in v",
                                                         "tie in v and distance",
                                                         "obstacle without candidate"};

Wires run(const Inputs& inputs) {
  const Params& p = inputs.params;
  Wires w;
  w.width = p.width;
  w.height = p.height;
  const AddressImage reference = referenceAddresses(p, w);
  const AddressImage current = currentAddresses(p, w);
  countReadWrite(p, reference, w);
  w.difference = difference(inputs, reference, current);
  w.gaussian = gaussian(p, w.difference);
  w.histogram = histogram(w.gaussian);
  w.mask = binarise(p, w.gaussian);
  w.threshold_out = otsu(p.threshold_in, w.histogram, w);
  w.eroded = erode(p, w.mask);
  w.bear.assign(80, 0);
  w.cor.assign(80, Contact{});
  for (int i = 0; i < 80; ++i) {
    const Line line = beamLine(p, i, w);
    w.bear[static_cast<size_t>(i)] = bearing(p, w.eroded, line, w);
    w.cor[static_cast<size_t>(i)] = contact(p, w.eroded, line, i, w);
  }
  w.peaks = peaks(p, w.bear, w);
  w.selected = select(p, w.peaks, w.cor, w);
  w.fifo = w.selected;  // rule 16: the 13 upper bits are 0
  return w;
}

}  // namespace oracle
