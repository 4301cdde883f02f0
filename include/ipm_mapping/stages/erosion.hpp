#pragma once

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// 3x3 erosion with all ones (the source, §3.4.3, §6.7): a pixel stays 255 where its whole
/// neighbourhood is 255. Outside the picture is background.
void erode(GrayView binary, GrayBuffer eroded);

}  // namespace ipm_mapping
