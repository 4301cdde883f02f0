#include "ipm_mapping/detectors/chain_detector.hpp"

#include "ipm_mapping/detectors/birds_eye_localization.hpp"
#include "ipm_mapping/stopwatch.hpp"

namespace ipm_mapping {

ChainDetector::ChainDetector(const Parameters& parameters)
    : ipm_(parameters.reference), segmentation_(parameters.segmentation), id_("chain") {
  if (parameters.detector.kind == DetectorKind::FirstArchitecture) {
    id_ = "first_architecture";
    locator_ =
        std::make_unique<BirdsEyeLocalization>(parameters.birds_eye, parameters.localization);
  } else {
    locator_ = std::make_unique<Localization>(parameters.localization);
  }
}

void ChainDetector::setCamera(const CameraModel& camera, const CameraPose& T_base_camera) {
  ipm_.setCamera(camera, T_base_camera);
  segmentation_.reset();
  for (Image<std::uint8_t>* image : {&difference_, &valid_, &mask_})
    image->ensure(camera.width(), camera.height());
}

void ChainDetector::reset() {
  ipm_.reset();
  segmentation_.reset();
}

FrameStatus ChainDetector::process(const Frame& frame, Obstacles& obstacles) {
  Stopwatch watch(times_);
  obstacles.clear();
  obstacles.frame = frame.index;
  FrameStatus status = ipm_.select(frame, obstacles.view);
  if (status == FrameStatus::Used) {
    ipm_.difference(difference_.view(), valid_.view());
    watch.lap("warp_difference");
    const Segmentation::Result segmented =
        segmentation_.process(difference_.view(), valid_.view(), mask_.view());
    obstacles.threshold = segmented.threshold;
    obstacles.separability = segmented.separability;
    watch.lap("segmentation");
    const GroundView view = obstacles.view;
    status = locator_->process(view, mask_.view(), obstacles);
    watch.lap("localization");
  }
  ipm_.remember();
  watch.lap("remember");
  return status;
}

}  // namespace ipm_mapping
