#pragma once
// Rule 18: the files of one frame.

#include <string>
#include <utility>
#include <vector>

#include "oracle.hpp"

namespace oracle {

/// One entry of params.txt: its place in Params and the values its rule allows.
struct Entry {
  const char* name;
  int Params::*value;
  int lowest, highest;
};
const std::vector<Entry>& entries();

/// Empty, or the name of the first entry whose value its rule refuses.
std::string checkRanges(const Params& params);

/// The text of params.txt, and back.
/// \throws std::invalid_argument naming a missing, unknown, repeated or refused entry.
std::string paramsText(const Params& params);
Params parseParams(const std::string& text);

/// Writes or reads params.txt, reference.pgm and current.pgm.
/// \throws std::invalid_argument where a file is missing or malformed.
void writeInputs(const Inputs& inputs, const std::string& folder);
Inputs readInputs(const std::string& folder);

/// Every text file of the outputs: name and content, in the order of rule 18.
std::vector<std::pair<std::string, std::string>> outputFiles(const Wires& wires);
void writeOutputs(const Wires& wires, const std::string& folder);

/// Empty if each file of `folder` equals the text of `wires` byte for byte, else the first
/// file and line that differ, with both lines.
std::string compareOutputs(const Wires& wires, const std::string& folder);

/// Empty if equal, else the first wire, index and both values that differ. `expected` is named
/// "oracle" in the message.
std::string firstMismatch(const Wires& expected, const Wires& found);

}  // namespace oracle
