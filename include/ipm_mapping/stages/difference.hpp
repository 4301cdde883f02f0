#pragma once

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// |a - b| in grey levels where valid is not 0, else 0 (the source, §6.4). All W x H.
void absoluteDifference(GrayView a, GrayView b, GrayView valid, GrayBuffer difference);

}  // namespace ipm_mapping
