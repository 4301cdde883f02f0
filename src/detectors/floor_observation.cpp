#include "ipm_mapping/detectors/floor_observation.hpp"

#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping {

sweep::FloorObservation floorObservation(const Detector& detector, const Frame& frame,
                                         FrameStatus status) {
  sweep::FloorObservation observation;
  observation.stamp = frame.stamp;
  observation.T_odom_base = frame.T_odom_base;
  observation.velocity = frame.velocity;
  observation.time_offset = frame.time_offset;
  const auto* sweep = dynamic_cast<const sweep::SweepDetector*>(&detector);
  if (sweep == nullptr) return observation;
  // The shorter window: odometry has gone less wrong in it, so the floor is found more surely.
  if (status == FrameStatus::Used) observation.motion = &sweep->refinedMotion(0);
  observation.reference = sweep->keptAsReference();
  return observation;
}

}  // namespace ipm_mapping
