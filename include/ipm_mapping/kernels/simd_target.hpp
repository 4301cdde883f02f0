#pragma once
// Which instruction set the kernels run on. Results do not depend on it, times do.

#include <optional>
#include <string>
#include <vector>

namespace ipm_mapping::kernels {

/// Names of the instruction sets that this build and this machine offer, widest first.
[[nodiscard]] std::vector<std::string> simdTargets();
/// Nothing wider than `name`, in any case of letters, from now on. Says what is wrong with a name
/// that is not among simdTargets(). Not while kernels run.
[[nodiscard]] std::optional<std::string> limitSimd(const std::string& name);
/// What kernels run on.
[[nodiscard]] std::string simdTarget();

}  // namespace ipm_mapping::kernels
