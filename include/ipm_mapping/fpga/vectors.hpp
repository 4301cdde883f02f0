#pragma once
// Golden vectors (rule 18): one frame's inputs and every wire as files that a VHDL or Verilog
// test bench can read.

#include <stdexcept>
#include <string>

#include "ipm_mapping/fpga/datapath.hpp"

namespace ipm_mapping::fpga {

/// Thrown when vectors cannot be read or written; what() names the file and, for params.txt, the
/// parameter.
class VectorError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Inputs that own their frames.
struct OwnedInputs {
  Image<std::uint8_t> reference;
  Image<std::uint8_t> current;
  FrameParameters parameters;

  [[nodiscard]] FrameInputs inputs() const {
    return {reference.view(), current.view(), parameters};
  }
};

/// Every wire of a frame, owned.
struct Wires {
  Image<TaggedPixel> difference, gaussian;
  Image<std::uint8_t> mask, eroded;
  Results results;

  /// Gives the images this size and returns views for Datapath::run.
  WireImages prepare(int width, int height);
};

/// Runs one frame and keeps every wire. Throws ParameterError when the parameters are refused.
void runAllWires(const FrameInputs& inputs, Wires& wires, Engine engine = Engine::Staged);

/// Parses params.txt; refuses a missing, unknown or repeated name and a value outside its wire.
[[nodiscard]] FrameParameters parseParameters(const std::string& text);
[[nodiscard]] std::string formatParameters(const FrameParameters& parameters);

/// Reads reference.pgm, current.pgm and params.txt.
[[nodiscard]] OwnedInputs readInputs(const std::string& directory);
void writeInputs(const FrameInputs& inputs, const std::string& directory);
void writeWires(const Wires& wires, const std::string& directory);

/// Inputs and wires of one frame into a directory, which is made when it does not exist.
void dumpVectors(const FrameInputs& inputs, const std::string& directory);

}  // namespace ipm_mapping::fpga
