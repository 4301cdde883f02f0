#pragma once

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// What a detector keeps of the last used frame, as pictures for people. Both return false and
/// leave `picture` alone where the detector has nothing of the kind.

/// How far the picture is from what the floor would show, in grey levels up to 255: camera pixels
/// for the chain, distances x azimuths for the sweep; 0 also where nothing was seen twice.
bool differencePicture(const Detector& detector, Image<std::uint8_t>& picture);
/// Scores of the sweep, candidate distances x beams: 0 for none, 255 from `score_cap` on.
bool scorePicture(const Detector& detector, double score_cap, Image<std::uint8_t>& picture);

}  // namespace ipm_mapping
