#include "ipm_mapping/ros/detector_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "ipm_mapping/detectors/chain_detector.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping {
namespace {

constexpr int residual_unit = 32;  // of SweepDetector::residual(), per grey level

template <class Pixel, class Shade>
bool draw(const ImageView<Pixel>& values, Image<std::uint8_t>& picture, Shade&& shade) {
  if (values.empty()) return false;
  picture.ensure(values.width, values.height);
  for (int v = 0; v < values.height; ++v)
    std::transform(values.row(v), values.row(v) + values.width, picture.row(v), shade);
  return true;
}

std::uint8_t greyOf(std::int16_t residual) {
  if (residual == kernels::no_residual) return 0;
  return static_cast<std::uint8_t>(std::min(std::abs(int{residual}) / residual_unit, 255));
}

}  // namespace

bool differencePicture(const Detector& detector, Image<std::uint8_t>& picture) {
  if (const auto* sweep = dynamic_cast<const sweep::SweepDetector*>(&detector))
    return draw(sweep->residual(), picture, greyOf);
  if (const auto* chain = dynamic_cast<const ChainDetector*>(&detector))
    return draw(chain->differenceImage(), picture, [](std::uint8_t grey) { return grey; });
  return false;
}

bool scorePicture(const Detector& detector, double score_cap, Image<std::uint8_t>& picture) {
  const auto* sweep = dynamic_cast<const sweep::SweepDetector*>(&detector);
  if (sweep == nullptr) return false;
  const double gain = 255.0 / score_cap;
  return draw(sweep->scores(), picture, [gain](float score) {
    return static_cast<std::uint8_t>(std::clamp(std::round(gain * score), 0.0, 255.0));
  });
}

}  // namespace ipm_mapping
