#pragma once

#include <vector>

#include "ipm_mapping/detectors/localization.hpp"
#include "ipm_mapping/parameters/birds_eye_parameters.hpp"
#include "ipm_mapping/stages/birds_eye.hpp"
#include "ipm_mapping/stages/radial_histogram.hpp"

namespace ipm_mapping {

/// Third link of the first architecture (the source, §3.5-3.8): the mask seen from above, peaks of
/// its polar histogram, and the distance at which each peak's radial histogram rises.
class BirdsEyeLocalization : public Locator {
 public:
  BirdsEyeLocalization(const BirdsEyeParameters& parameters,
                       const LocalizationParameters& localization)
      : parameters_(parameters), localization_(localization) {}

  FrameStatus process(const GroundView& view, GrayView obstacle_mask,
                      Obstacles& obstacles) override;

  /// The bird's-eye mask of the last process(), W x H.
  [[nodiscard]] GrayView birdsEyeMask() const { return birds_eye_mask_.view(); }

 private:
  void prepare(const GroundView& view);
  void describeBearings(const BirdsEye& birds_eye, const GroundView& view, Obstacles& obstacles);
  void addContact(const BirdsEye& birds_eye, const GroundView& view, const Peak& peak,
                  Obstacles& obstacles);

  BirdsEyeParameters parameters_;
  LocalizationParameters localization_;
  CameraModel camera_;
  CameraPose T_base_camera_ = CameraPose::Identity();
  PolarGrid grid_;
  PolarGrid::Counts counts_;
  std::vector<Peak> peaks_;
  Image<std::uint8_t> birds_eye_mask_;
};

}  // namespace ipm_mapping
