#pragma once

#include <memory>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/parameters.hpp"

namespace ipm_mapping {

/// The detector that `parameters.detector.kind` names.
[[nodiscard]] std::unique_ptr<Detector> makeDetector(const Parameters& parameters);

}  // namespace ipm_mapping
