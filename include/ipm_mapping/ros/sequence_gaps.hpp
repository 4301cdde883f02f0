#pragma once

#include <cstdint>
#include <optional>

namespace ipm_mapping {

/// How many messages of a topic were sent and did not come, by the numbers that publishers give
/// them. A number that is smaller, or larger by far, belongs to another publisher.
class SequenceGaps {
 public:
  /// Messages missing between the last one and this one.
  std::uint32_t missing(std::uint32_t number) {
    const std::uint32_t gap = last_ && number > *last_ ? number - *last_ - 1 : 0;
    last_ = number;
    return gap < widest ? gap : 0;
  }

 private:
  static constexpr std::uint32_t widest = 1000;
  std::optional<std::uint32_t> last_;
};

}  // namespace ipm_mapping
