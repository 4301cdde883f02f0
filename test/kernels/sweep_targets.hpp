#pragma once
// Runs a body once for every instruction set that this machine and this build offer.

#include <gtest/gtest.h>

#include <hwy/highway.h>
#include <cstdint>

namespace ipm_mapping::test {

/// `body(name)` with each target alone, widest first; the scalar or baseline one comes last.
template <class Body>
void withEverySweepTarget(Body&& body) {
  hwy::SetSupportedTargetsForTest(0);
  const auto all = hwy::SupportedTargets();
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    SCOPED_TRACE(hwy::TargetName(target));
    body();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace ipm_mapping::test
