#include "vectors.hpp"

#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace oracle {
namespace {

constexpr int coefficient = 131071;  // 18 bits signed
constexpr int distortion = 8191;     // 14 bits signed

}  // namespace

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = {
      {"width", &Params::width, 1, 640},
      {"height", &Params::height, 1, 480},
      {"h11", &Params::h11, -coefficient - 1, coefficient},
      {"h12", &Params::h12, -coefficient - 1, coefficient},
      {"h13", &Params::h13, -coefficient - 1, coefficient},
      {"h21", &Params::h21, -coefficient - 1, coefficient},
      {"h22", &Params::h22, -coefficient - 1, coefficient},
      {"h23", &Params::h23, -coefficient - 1, coefficient},
      {"h31", &Params::h31, -coefficient - 1, coefficient},
      {"h32", &Params::h32, -coefficient - 1, coefficient},
      {"h33", &Params::h33, -coefficient - 1, coefficient},
      {"horizon_a", &Params::horizon_a, -coefficient - 1, coefficient},
      {"horizon_b", &Params::horizon_b, -coefficient - 1, coefficient},
      {"horizon_c", &Params::horizon_c, -coefficient - 1, coefficient},
      {"use_horizon", &Params::use_horizon, 0, 1},
      {"fx", &Params::fx, 1, 65535},
      {"fy", &Params::fy, 1, 65535},
      {"cx", &Params::cx, 0, 65535},
      {"cy", &Params::cy, 0, 65535},
      {"k1", &Params::k1, -distortion - 1, distortion},
      {"k2", &Params::k2, -distortion - 1, distortion},
      {"k3", &Params::k3, -distortion - 1, distortion},
      {"r2_max", &Params::r2_max, 0, 16777215},
      {"focus_u", &Params::focus_u, -8192, 8191},
      {"focus_v", &Params::focus_v, -8192, 8191},
      {"threshold_in", &Params::threshold_in, 0, 255},
      {"min_threshold", &Params::min_threshold, 0, 255},
      {"score_min", &Params::score_min, 0, 511},
      {"min_height", &Params::min_height, 0, 511},
      {"valley_threshold", &Params::valley_threshold, 1, 31},
      {"bearing_tolerance", &Params::bearing_tolerance, 0, 79},
      {"undistort_current", &Params::undistort_current, 0, 1},
      {"paper_order", &Params::paper_order, 0, 1},
      {"method", &Params::method, 0, 1},
      {"single_bin_peaks", &Params::single_bin_peaks, 0, 1},
      {"free_space_rule", &Params::free_space_rule, 0, 1},
      {"memory_rows", &Params::memory_rows, 1, 524288}};
  return list;
}

std::string checkRanges(const Params& params) {
  for (const Entry& entry : entries()) {
    const int value = params.*entry.value;
    if (value < entry.lowest || value > entry.highest) return entry.name;
  }
  if (params.focus_v == 0) return "focus_v";
  const int rows = params.memory_rows;
  if (rows < params.height || rows > 524288 / params.width) return "memory_rows";
  return "";
}

std::string paramsText(const Params& params) {
  std::ostringstream text;
  for (const Entry& entry : entries()) text << entry.name << " = " << params.*entry.value << '\n';
  return text.str();
}

Params parseParams(const std::string& text) {
  std::map<std::string, int> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, equals;
    int value = 0;
    if (!(words >> name >> equals >> value) || equals != "=") throw std::invalid_argument(line);
    if (!values.emplace(name, value).second) throw std::invalid_argument(name + " is repeated");
  }
  Params params;
  for (const Entry& entry : entries()) {
    const auto found = values.find(entry.name);
    if (found == values.end()) throw std::invalid_argument(entry.name + std::string(" is missing"));
    params.*entry.value = found->second;
    values.erase(found);
  }
  if (!values.empty()) throw std::invalid_argument(values.begin()->first + " is unknown");
  const std::string refused = checkRanges(params);
  if (!refused.empty()) throw std::invalid_argument(refused + " is out of range");
  return params;
}

namespace {

std::string readFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::invalid_argument(path + " cannot be read");
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

void writeFile(const std::string& path, const std::string& content) {
  std::ofstream out(path, std::ios::binary);
  out << content;
  out.close();
  if (!out) throw std::invalid_argument(path + " cannot be written");
}

std::string pgm(const Params& p, const std::vector<uint8_t>& image) {
  std::string text = "P5\n" + std::to_string(p.width) + " " + std::to_string(p.height) + "\n255\n";
  return text.append(image.begin(), image.end());
}

std::vector<uint8_t> parsePgm(const Params& p, const std::string& content) {
  std::istringstream in(content);
  std::string magic;
  int width = 0, height = 0, highest = 0;
  in >> magic >> width >> height >> highest;
  const auto size = static_cast<size_t>(p.width * p.height);
  if (!in || magic != "P5" || highest != 255 || width != p.width || height != p.height ||
      content.size() < size) {
    throw std::invalid_argument("not a P5 image of the size of params.txt");
  }
  return std::vector<uint8_t>(content.end() - static_cast<std::ptrdiff_t>(size), content.end());
}

std::string hex(uint32_t value, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "%0*x\n", digits, value);
  return text;
}

template <class Values>
std::string hexLines(const Values& values, int digits) {
  std::string text;
  for (const uint32_t value : values) text += hex(value, digits);
  return text;
}

template <class Values>
std::string decimalLines(const Values& values) {
  std::string text;
  for (const auto value : values) text += std::to_string(value) + "\n";
  return text;
}

std::string bitRows(const Wires& w, const std::vector<uint8_t>& image) {
  std::string text;
  for (size_t i = 0; i < image.size(); ++i) {
    text += image[i] == 0 ? '0' : '1';
    if ((i + 1) % static_cast<size_t>(w.width) == 0) text += '\n';
  }
  return text;
}

std::string contactLines(const std::vector<Contact>& cor) {
  std::string text;
  for (const Contact& contact : cor)
    text += std::to_string(contact.flag) + " " + hex(contact.word, 7);
  return text;
}

std::string counterLines(const Wires& w) {
  std::string text;
  for (size_t i = 0; i < CounterCount; ++i) {
    text += std::string(counter_names[i]) + " " + std::to_string(w.overflow[i]) + "\n";
  }
  return text;
}

}  // namespace

void writeInputs(const Inputs& inputs, const std::string& folder) {
  writeFile(folder + "/params.txt", paramsText(inputs.params));
  writeFile(folder + "/reference.pgm", pgm(inputs.params, inputs.reference));
  writeFile(folder + "/current.pgm", pgm(inputs.params, inputs.current));
}

Inputs readInputs(const std::string& folder) {
  Inputs inputs;
  inputs.params = parseParams(readFile(folder + "/params.txt"));
  inputs.reference = parsePgm(inputs.params, readFile(folder + "/reference.pgm"));
  inputs.current = parsePgm(inputs.params, readFile(folder + "/current.pgm"));
  return inputs;
}

std::vector<std::pair<std::string, std::string>> outputFiles(const Wires& w) {
  return {{"difference.txt", hexLines(w.difference, 3)},
          {"gaussian.txt", hexLines(w.gaussian, 3)},
          {"mask.txt", bitRows(w, w.mask)},
          {"eroded.txt", bitRows(w, w.eroded)},
          {"histogram.txt", decimalLines(w.histogram)},
          {"bear.txt", decimalLines(w.bear)},
          {"threshold_out.txt", std::to_string(w.threshold_out) + "\n"},
          {"cor.txt", contactLines(w.cor)},
          {"peaks.txt", hexLines(w.peaks, 4)},
          {"selected.txt", hexLines(w.selected, 5)},
          {"fifo.txt", hexLines(w.fifo, 8)},
          {"overflow.txt", counterLines(w)}};
}

void writeOutputs(const Wires& wires, const std::string& folder) {
  for (const auto& file : outputFiles(wires)) writeFile(folder + "/" + file.first, file.second);
}

namespace {

std::string firstLineThatDiffers(const std::string& expected, const std::string& found) {
  std::istringstream left(expected), right(found);
  for (int number = 1;; ++number) {
    std::string a = "(end)", b = "(end)";
    const bool has_left = static_cast<bool>(std::getline(left, a));
    const bool has_right = static_cast<bool>(std::getline(right, b));
    if (!has_left && !has_right) return "the line ends differ";
    if (a != b || has_left != has_right) {
      return "line " + std::to_string(number) + ": oracle '" + a + "', found '" + b + "'";
    }
  }
}

/// Empty, or which element of one wire differs.
template <class Expected, class Found, class Print>
std::string differs(const char* wire, const Expected& a, const Found& b, Print print) {
  if (a.size() != b.size()) {
    return std::string(wire) + " has " + std::to_string(a.size()) + " entries in the oracle, " +
           std::to_string(b.size()) + " found";
  }
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] == b[i]) continue;
    return std::string(wire) + "[" + std::to_string(i) + "]: oracle " + print(a[i]) + ", found " +
           print(b[i]);
  }
  return "";
}

std::string printNumber(int64_t value) { return std::to_string(value); }

std::string printContact(const Contact& contact) {
  char text[32];
  std::snprintf(text, sizeof text, "%d %07x", contact.flag, contact.word);
  return text;
}

}  // namespace

std::string compareOutputs(const Wires& wires, const std::string& folder) {
  for (const auto& file : outputFiles(wires)) {
    const std::string found = readFile(folder + "/" + file.first);
    if (found != file.second) {
      return file.first + " " + firstLineThatDiffers(file.second, found);
    }
  }
  return "";
}

std::string firstMismatch(const Wires& expected, const Wires& found) {
  const std::vector<int> threshold_a{expected.threshold_out}, threshold_b{found.threshold_out};
  std::vector<std::string> results = {
      differs("difference", expected.difference, found.difference, printNumber),
      differs("gaussian", expected.gaussian, found.gaussian, printNumber),
      differs("mask", expected.mask, found.mask, printNumber),
      differs("eroded", expected.eroded, found.eroded, printNumber),
      differs("histogram", expected.histogram, found.histogram, printNumber),
      differs("threshold_out", threshold_a, threshold_b, printNumber),
      differs("bear", expected.bear, found.bear, printNumber),
      differs("cor", expected.cor, found.cor, printContact),
      differs("peaks", expected.peaks, found.peaks, printNumber),
      differs("selected", expected.selected, found.selected, printNumber),
      differs("fifo", expected.fifo, found.fifo, printNumber)};
  for (size_t i = 0; i < CounterCount; ++i) {
    const std::array<int64_t, 1> a{expected.overflow[i]}, b{found.overflow[i]};
    const std::string name = std::string("overflow ") + counter_names[i];
    results.push_back(differs(name.c_str(), a, b, printNumber));
  }
  for (const std::string& result : results) {
    if (!result.empty()) return result;
  }
  return "";
}

}  // namespace oracle
