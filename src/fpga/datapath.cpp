#include "ipm_mapping/fpga/datapath.hpp"

#include <algorithm>

#include "ipm_mapping/fpga/difference.hpp"
#include "ipm_mapping/fpga/erosion.hpp"
#include "ipm_mapping/fpga/fast_engine.hpp"
#include "ipm_mapping/fpga/gaussian.hpp"

namespace ipm_mapping::fpga {

struct Datapath::Workspace {
  Image<TaggedPixel> difference, gaussian;
  Image<std::uint8_t> mask, eroded;
  FastEngine fast;

  explicit Workspace(const FastKernels& kernels) : fast(kernels) {}
  void staged(const FrameInputs& inputs, const WireImages& wanted, Results& results);
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

/// The chapter's modules, one after the other.
void Datapath::Workspace::staged(const FrameInputs& inputs, const WireImages& wanted, Results& r) {
  const FrameParameters& p = inputs.parameters;
  const auto difference_image = bufferFor(wanted.difference, difference, p);
  const auto gaussian_image = bufferFor(wanted.gaussian, gaussian, p);
  const auto mask_image = bufferFor(wanted.mask, mask, p);
  const auto eroded_image = bufferFor(wanted.eroded, eroded, p);
  const int threshold =
      maskThreshold(static_cast<int>(p.threshold_in), static_cast<int>(p.min_threshold));

  fpga::difference(inputs, difference_image, r.overflow);      // rules 2-7
  fpga::gaussian(difference_image, gaussian_image);            // rule 8
  fpga::histogram(gaussian_image, r.histogram);                // rule 9
  fpga::binarise(gaussian_image, threshold, mask_image);       // rule 9
  fpga::erosion(mask_image, eroded_image);                     // rule 8
  fpga::localize(eroded_image, p, r.bear, r.cor, r.overflow);  // rules 11 and 12
}

Datapath::Datapath(Engine engine) : Datapath(engine, *supportedKernels().back()) {}
Datapath::Datapath(Engine engine, const FastKernels& kernels)
    : workspace_(std::make_unique<Workspace>(kernels)), engine_(engine) {}
Datapath::~Datapath() = default;
Datapath::Datapath(Datapath&&) noexcept = default;
Datapath& Datapath::operator=(Datapath&&) noexcept = default;

bool Datapath::run(const FrameInputs& inputs, const WireImages& wanted) {
  const FrameParameters& p = inputs.parameters;
  Results& r = results_;
  clear(r, p);
  if (!runnable(inputs)) return false;
  if (engine_ == Engine::Fast && std::min(p.width, p.height) >= FastEngine::smallest_side) {
    workspace_->fast.run(inputs, wanted, r);
  } else {
    workspace_->staged(inputs, wanted, r);
  }
  r.threshold_out = otsuThreshold(r.histogram).value_or(r.threshold_out);             // rule 9
  freeSpace(r.bear, p, r.peaks, r.overflow);                                          // rule 14
  selectContacts(r.cor, r.peaks, static_cast<int>(p.bearing_tolerance), r.selected);  // rule 15
  return true;
}

}  // namespace ipm_mapping::fpga
