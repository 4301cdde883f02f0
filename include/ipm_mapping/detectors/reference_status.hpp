#pragma once

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/geometry/reference_selector.hpp"

namespace ipm_mapping {

/// What the lack of a reference means for the frame.
[[nodiscard]] inline FrameStatus frameStatus(ReferenceVerdict verdict) {
  switch (verdict) {
    case ReferenceVerdict::Chosen:
      return FrameStatus::Used;
    case ReferenceVerdict::NoMotion:
      return FrameStatus::NoMotion;
    case ReferenceVerdict::NoReference:
      return FrameStatus::NoReference;
    case ReferenceVerdict::TooMuchRotation:
      return FrameStatus::TooMuchRotation;
  }
  return FrameStatus::NoReference;
}

}  // namespace ipm_mapping
