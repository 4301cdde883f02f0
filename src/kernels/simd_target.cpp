#include "ipm_mapping/kernels/simd_target.hpp"

#include <hwy/highway.h>

#include <algorithm>
#include <cctype>
#include <cstdint>

namespace ipm_mapping::kernels {
namespace {

/// Widest first.
template <class Visitor>
void visitTargets(Visitor&& visit) {
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1)
    visit(rest & -rest);
}

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

std::vector<std::string> simdTargets() {
  std::vector<std::string> names;
  visitTargets([&](std::int64_t target) { names.emplace_back(hwy::TargetName(target)); });
  return names;
}

std::optional<std::string> limitSimd(const std::string& name) {
  std::int64_t wanted = 0;
  std::string known;
  visitTargets([&](std::int64_t target) {
    if (lowerCase(hwy::TargetName(target)) == lowerCase(name)) wanted = target;
    known += (known.empty() ? "" : ", ") + std::string(hwy::TargetName(target));
  });
  if (wanted == 0) return "no instruction set '" + name + "' here; there are " + known;
  hwy::DisableTargets(wanted - 1);  // a wider one is a lower bit
  return std::nullopt;
}

std::string simdTarget() { return simdTargets().front(); }

}  // namespace ipm_mapping::kernels
