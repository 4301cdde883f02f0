#pragma once

#include <string>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::fpga {

/// Binary P5 with maxval 255. Both throw VectorError naming the file.
[[nodiscard]] Image<std::uint8_t> readPgm(const std::string& path);
void writePgm(const GrayView& image, const std::string& path);

}  // namespace ipm_mapping::fpga
