#include "ipm_mapping/fpga/frame_parameters.hpp"

#include <vector>

namespace ipm_mapping::fpga {
namespace {

std::string outside(const char* name, Integer value, Integer lowest, Integer highest) {
  return std::string(name) + " = " + std::to_string(value) + " is outside " +
         std::to_string(lowest) + " ... " + std::to_string(highest);
}

}  // namespace

void validate(const FrameParameters& parameters) {
  FrameParameters::fields(parameters,
                          [](const char* name, Integer value, Integer lowest, Integer highest) {
                            if (value < lowest || value > highest) {
                              throw ParameterError(outside(name, value, lowest, highest));
                            }
                          });
  if (parameters.focus_v == 0) throw ParameterError("focus_v = 0: the beam has no direction");
}

bool runnable(const FrameInputs& inputs) {
  const FrameParameters& p = inputs.parameters;
  const auto of_size = [&p](const GrayView& image) {
    return !image.empty() && image.width == p.width && image.height == p.height;
  };
  return p.width <= max_width && p.height <= max_height && of_size(inputs.reference) &&
         of_size(inputs.current) && p.focus_v != 0 && p.fx > 0 && p.fy > 0;
}

bool FrameParameters::operator==(const FrameParameters& other) const {
  std::vector<Integer> mine;
  fields(*this, [&mine](const char*, Integer value, Integer, Integer) { mine.push_back(value); });
  bool equal = true;
  std::size_t i = 0;
  fields(other, [&](const char*, Integer value, Integer, Integer) {
    equal = equal && value == mine[i++];
  });
  return equal;
}

}  // namespace ipm_mapping::fpga
