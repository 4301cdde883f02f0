#pragma once

#include <memory>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/detectors/inverse_perspective_mapping.hpp"
#include "ipm_mapping/detectors/localization.hpp"
#include "ipm_mapping/detectors/segmentation.hpp"
#include "ipm_mapping/parameters.hpp"

namespace ipm_mapping {

/// The source's architectures in floating point, in one piece: what the nodelets Ipm, Segmentation
/// and Localization (or BirdsEyeLocalization: the first architecture) do when chained.
class ChainDetector : public Detector {
 public:
  explicit ChainDetector(const Parameters& parameters);

  void setCamera(const CameraModel& camera, const CameraPose& T_base_camera) override;
  void reset() override;
  FrameStatus process(const Frame& frame, Obstacles& obstacles) override;
  [[nodiscard]] const std::vector<StageTime>& stageTimes() const override { return times_; }
  [[nodiscard]] const char* id() const override { return id_; }

  /// Pictures of the last used frame.
  [[nodiscard]] GrayView rectified() const { return ipm_.rectified(); }
  [[nodiscard]] GrayView differenceImage() const { return difference_.view(); }
  [[nodiscard]] GrayView obstacleMask() const { return mask_.view(); }

 private:
  InversePerspectiveMapping ipm_;
  Segmentation segmentation_;
  std::unique_ptr<Locator> locator_;
  const char* id_;
  Image<std::uint8_t> difference_, valid_, mask_;
  std::vector<StageTime> times_;
};

}  // namespace ipm_mapping
