#include "ipm_mapping/fpga/vectors.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "ipm_mapping/fpga/pgm.hpp"

namespace ipm_mapping::fpga {
namespace {

/// A number in lower-case hex, zero-padded.
void putHex(std::string& out, std::uint32_t value, int digits) {
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) {
    out += "0123456789abcdef"[value >> shift & 0xf];
  }
}

void writeFile(const std::string& directory, const char* name, const std::string& text) {
  const std::string path = directory + "/" + name;
  std::ofstream out(path, std::ios::binary);
  if (!out.write(text.data(), static_cast<std::streamsize>(text.size())).flush()) {
    throw VectorError(path + ": cannot be written");
  }
}

std::string readFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw VectorError(path + ": cannot be opened");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string hexPixels(const Image<TaggedPixel>& image) {
  std::string text;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      putHex(text, image.at(u, v), 3);
      text += '\n';
    }
  }
  return text;
}

std::string bitRows(const Image<std::uint8_t>& image) {
  std::string text;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) text += image.at(u, v) ? '1' : '0';
    text += '\n';
  }
  return text;
}

template <class Values>
std::string decimals(const Values& values) {
  std::string text;
  for (const auto value : values) text += std::to_string(value) + '\n';
  return text;
}

template <class Word>
std::string hexWords(const WordList<Word>& words, int digits, std::uint32_t mask) {
  std::string text;
  for (const Word word : words) {
    putHex(text, word & mask, digits);
    text += '\n';
  }
  return text;
}

std::string contactLines(const Contacts& cor) {
  std::string text;
  for (const ContactEntry& entry : cor) {
    text += entry.found ? "1 " : "0 ";
    putHex(text, entry.word, 7);
    text += '\n';
  }
  return text;
}

std::string overflowLines(const OverflowCounters& counters) {
  std::string text;
  for (std::size_t i = 0; i < wire_count; ++i) {
    text += std::string(wire_names[i]) + ' ' + std::to_string(counters.counts()[i]) + '\n';
  }
  return text;
}

void makeDirectory(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw VectorError(directory + ": " + error.message());
}

}  // namespace

WireImages Wires::prepare(int width, int height) {
  difference.ensure(width, height);
  gaussian.ensure(width, height);
  mask.ensure(width, height);
  eroded.ensure(width, height);
  return {difference.view(), gaussian.view(), mask.view(), eroded.view()};
}

void runAllWires(const FrameInputs& inputs, Wires& wires, Engine engine) {
  validate(inputs.parameters);
  const FrameParameters& p = inputs.parameters;
  Datapath datapath(engine);
  const WireImages views = wires.prepare(static_cast<int>(p.width), static_cast<int>(p.height));
  if (!datapath.run(inputs, views)) {
    throw VectorError("the frames are not of the size that width and height state");
  }
  wires.results = datapath.results();
}

OwnedInputs readInputs(const std::string& directory) {
  OwnedInputs inputs;
  inputs.parameters = parseParameters(readFile(directory + "/params.txt"));
  const auto read = [&](const char* name) {
    Image<std::uint8_t> image = readPgm(directory + "/" + name);
    if (image.width() != inputs.parameters.width || image.height() != inputs.parameters.height) {
      throw VectorError(directory + "/" + name + ": not of the size in params.txt");
    }
    return image;
  };
  inputs.reference = read("reference.pgm");
  inputs.current = read("current.pgm");
  return inputs;
}

void writeInputs(const FrameInputs& inputs, const std::string& directory) {
  makeDirectory(directory);
  writePgm(inputs.reference, directory + "/reference.pgm");
  writePgm(inputs.current, directory + "/current.pgm");
  writeFile(directory, "params.txt", formatParameters(inputs.parameters));
}

void writeWires(const Wires& wires, const std::string& directory) {
  const Results& r = wires.results;
  constexpr std::uint32_t point_bits = 0x7ffff;
  makeDirectory(directory);
  writeFile(directory, "difference.txt", hexPixels(wires.difference));
  writeFile(directory, "gaussian.txt", hexPixels(wires.gaussian));
  writeFile(directory, "mask.txt", bitRows(wires.mask));
  writeFile(directory, "eroded.txt", bitRows(wires.eroded));
  writeFile(directory, "histogram.txt", decimals(r.histogram));
  writeFile(directory, "bear.txt", decimals(r.bear));
  writeFile(directory, "threshold_out.txt", std::to_string(r.threshold_out) + '\n');
  writeFile(directory, "cor.txt", contactLines(r.cor));
  writeFile(directory, "peaks.txt", hexWords(r.peaks, 4, 0xffff));
  writeFile(directory, "selected.txt", hexWords(r.selected, 5, point_bits));
  writeFile(directory, "fifo.txt", hexWords(r.selected, 8, point_bits));
  writeFile(directory, "overflow.txt", overflowLines(r.overflow));
}

void dumpVectors(const FrameInputs& inputs, const std::string& directory) {
  Wires wires;
  runAllWires(inputs, wires);
  writeInputs(inputs, directory);
  writeWires(wires, directory);
}

}  // namespace ipm_mapping::fpga
