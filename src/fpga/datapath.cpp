#include "ipm_mapping/fpga/datapath.hpp"

#include "ipm_mapping/fpga/difference.hpp"
#include "ipm_mapping/fpga/erosion.hpp"
#include "ipm_mapping/fpga/gaussian.hpp"

namespace ipm_mapping::fpga {

struct Datapath::Workspace {
  Image<TaggedPixel> difference, gaussian;
  Image<std::uint8_t> mask, eroded;
};

namespace {

/// The caller's buffer, or the workspace's own where the caller does not want the wire.
template <class T>
ImageView<T> bufferFor(const ImageView<T>& wanted, Image<T>& own, const FrameParameters& p) {
  if (!wanted.empty()) return wanted;
  own.ensure(static_cast<int>(p.width), static_cast<int>(p.height));
  return own.view();
}

void clear(Results& results, const FrameParameters& p) {
  results.histogram.fill(0);
  results.threshold_out = static_cast<std::uint8_t>(p.threshold_in);
  results.bear.fill(0);
  results.cor.fill({});
  results.peaks.clear();
  results.selected.clear();
  results.overflow.clear();
}

}  // namespace

bool Results::operator==(const Results& o) const {
  return histogram == o.histogram && threshold_out == o.threshold_out && bear == o.bear &&
         cor == o.cor && peaks == o.peaks && selected == o.selected && overflow == o.overflow;
}

Datapath::Datapath(Engine engine) : workspace_(std::make_unique<Workspace>()), engine_(engine) {}
Datapath::~Datapath() = default;
Datapath::Datapath(Datapath&&) noexcept = default;
Datapath& Datapath::operator=(Datapath&&) noexcept = default;

bool Datapath::run(const FrameInputs& inputs, const WireImages& wanted) {
  const FrameParameters& p = inputs.parameters;
  Results& r = results_;
  clear(r, p);
  if (!runnable(inputs)) return false;
  const auto difference_image = bufferFor(wanted.difference, workspace_->difference, p);
  const auto gaussian_image = bufferFor(wanted.gaussian, workspace_->gaussian, p);
  const auto mask = bufferFor(wanted.mask, workspace_->mask, p);
  const auto eroded = bufferFor(wanted.eroded, workspace_->eroded, p);

  difference(inputs, difference_image, r.overflow);  // rules 2-7
  gaussian(difference_image, gaussian_image);        // rule 8
  histogram(gaussian_image, r.histogram);            // rule 9
  r.threshold_out = otsuThreshold(r.histogram).value_or(r.threshold_out);
  binarise(gaussian_image,
           maskThreshold(static_cast<int>(p.threshold_in), static_cast<int>(p.min_threshold)),
           mask);
  erosion(mask, eroded);                           // rule 8
  localize(eroded, p, r.bear, r.cor, r.overflow);  // rules 11, 12
  freeSpace(r.bear, p, r.peaks, r.overflow);       // rule 14
  selectContacts(r.cor, r.peaks, static_cast<int>(p.bearing_tolerance), r.selected);  // rule 15
  return true;
}

}  // namespace ipm_mapping::fpga
