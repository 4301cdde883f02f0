#pragma once

#include <string>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/frame_gate.hpp"

namespace ipm_mapping {

struct BagTopics;
struct RunReport;

/// Why a frame got no pose; `odometry` names the topic.
[[nodiscard]] std::string explain(GateDrop reason, const std::string& odometry);
/// Why an odometry message was refused.
[[nodiscard]] const char* explain(OdometryVerdict refusal);
/// Why a detector gave no answer.
[[nodiscard]] std::string explain(FrameStatus status);

/// Frames of a run that were lost through a fault, as a sentence with counts; empty where none was.
[[nodiscard]] std::string dropConcern(const RunReport& report, const BagTopics& topics);

/// What went wrong with the frames of a run, as a sentence with counts; empty where all that were
/// not used were left out for good reasons and some were used.
[[nodiscard]] std::string frameConcern(const RunReport& report, const BagTopics& topics);

}  // namespace ipm_mapping
