// params.txt of rule 18: `name = integer`, one a line.
#include <map>
#include <set>
#include <sstream>

#include "ipm_mapping/fpga/vectors.hpp"

namespace ipm_mapping::fpga {
namespace {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

Integer integerOf(const std::string& name, const std::string& text) {
  std::size_t used = 0;
  Integer value = 0;
  try {
    value = std::stoll(text, &used);
  } catch (const std::exception&) {
    used = std::string::npos;
  }
  if (used != text.size()) throw VectorError("params.txt: " + name + ": not an integer: " + text);
  return value;
}

std::set<std::string> knownNames() {
  std::set<std::string> names;
  const FrameParameters none;
  FrameParameters::fields(
      none, [&names](const char* name, Integer, Integer, Integer) { names.insert(name); });
  return names;
}

std::map<std::string, Integer> assignments(const std::string& text) {
  std::map<std::string, Integer> values;
  const std::set<std::string> known = knownNames();
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (trimmed(line).empty()) continue;
    const auto equals = line.find('=');
    if (equals == std::string::npos) throw VectorError("params.txt: no '=' in: " + line);
    const std::string name = trimmed(line.substr(0, equals));
    if (!known.count(name)) throw VectorError("params.txt: unknown name: " + name);
    const Integer value = integerOf(name, trimmed(line.substr(equals + 1)));
    if (!values.emplace(name, value).second) {
      throw VectorError("params.txt: repeated name: " + name);
    }
  }
  return values;
}

}  // namespace

FrameParameters parseParameters(const std::string& text) {
  const std::map<std::string, Integer> values = assignments(text);
  FrameParameters parameters;
  FrameParameters::fields(parameters,
                          [&values](const char* name, Integer& value, Integer, Integer) {
                            const auto found = values.find(name);
                            if (found == values.end()) {
                              throw VectorError(std::string("params.txt: missing name: ") + name);
                            }
                            value = found->second;
                          });
  validate(parameters);
  return parameters;
}

std::string formatParameters(const FrameParameters& parameters) {
  std::string text;
  FrameParameters::fields(parameters, [&text](const char* name, Integer value, Integer, Integer) {
    text += std::string(name) + " = " + std::to_string(value) + '\n';
  });
  return text;
}

}  // namespace ipm_mapping::fpga
