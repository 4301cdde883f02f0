#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// 3x3 erosion with all ones (the source, §3.4.3, §6.7): a pixel stays 255 where its whole
/// neighbourhood is 255. Outside the picture is background.
class Erosion {
 public:
  void operator()(GrayView binary, GrayBuffer eroded);

 private:
  std::vector<std::uint8_t> columns_;
};

}  // namespace ipm_mapping
