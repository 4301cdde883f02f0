#include "ipm_mapping/ros/wiring.hpp"

namespace ipm_mapping {

std::unique_lock<std::mutex> wiringLock() {
  static std::mutex mutex;
  return std::unique_lock<std::mutex>(mutex);
}

}  // namespace ipm_mapping
