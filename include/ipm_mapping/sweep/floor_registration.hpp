#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/geometry/camera.hpp"
#include "ipm_mapping/sweep/floor_pair.hpp"

namespace ipm_mapping::sweep {

/// How far a patch of floor in the current view lies from where the reference says it is.
struct PatchShift {
  Eigen::Vector2d pixel;  ///< raw, middle of the patch in the current view
  Eigen::Vector2d shift;  ///< raw pixels, reference view
};

/// Measures, patch by patch, what is left between two views after the floor has been aligned: a few
/// Lucas-Kanade steps on the rectified grey levels, turned into raw pixels. Patches that do not
/// fit anywhere near (no texture, no floor) are left out. For people and tools: it allocates.
[[nodiscard]] std::vector<PatchShift> floorRegistration(const FramePair& pair,
                                                        const FloorPair& floor,
                                                        const PairEvidence& alignment,
                                                        const CameraModel& camera,
                                                        const CameraPose& T_base_rectified);

}  // namespace ipm_mapping::sweep
