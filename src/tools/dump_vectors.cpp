// Writes golden vectors for a hardware test bench: one frame's inputs and every wire.
#include <cstring>
#include <iostream>
#include <optional>
#include <string>

#include "ipm_mapping/fpga/vectors.hpp"

namespace {

constexpr int exit_usage = 2;
constexpr int exit_input = 3;

struct Arguments {
  std::string inputs;
  std::string out;
};

std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--inputs") == 0)
      arguments.inputs = argv[i + 1];
    else if (std::strcmp(argv[i], "--out") == 0)
      arguments.out = argv[i + 1];
    else
      return std::nullopt;
  }
  if (argc % 2 == 0 || arguments.inputs.empty() || arguments.out.empty()) return std::nullopt;
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  const auto arguments = parse(argc, argv);
  if (!arguments) {
    std::cerr << "usage: dump_vectors --inputs DIR --out DIR\n";
    return exit_usage;
  }
  try {
    const auto owned = ipm_mapping::fpga::readInputs(arguments->inputs);
    ipm_mapping::fpga::dumpVectors(owned.inputs(), arguments->out);
  } catch (const std::exception& error) {
    std::cerr << "dump_vectors: " << error.what() << '\n';
    return exit_input;
  }
  return 0;
}
