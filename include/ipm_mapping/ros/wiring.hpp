#pragma once

#include <mutex>

namespace ipm_mapping {

/// Held while a nodelet subscribes or advertises. roscpp connects a publisher and a subscriber of
/// one process twice when one thread advertises a topic while another subscribes to it: each of
/// them sees the other's half and completes it, and every message then arrives twice.
[[nodiscard]] std::unique_lock<std::mutex> wiringLock();

}  // namespace ipm_mapping
