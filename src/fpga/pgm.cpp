#include "ipm_mapping/fpga/pgm.hpp"

#include <cctype>
#include <fstream>

#include "ipm_mapping/fpga/vectors.hpp"

namespace ipm_mapping::fpga {
namespace {

constexpr int largest_side = 1 << 15;

/// Next number of the header; comments run from # to the end of the line.
int headerNumber(std::istream& in, const std::string& path, const char* what) {
  while (std::isspace(in.peek()) || in.peek() == '#') {
    if (in.get() == '#') {
      std::string comment;
      std::getline(in, comment);
    }
  }
  int value = 0;
  if (!(in >> value) || value < 1 || value > largest_side) {
    throw VectorError(path + ": bad " + what + " in the PGM header");
  }
  return value;
}

}  // namespace

Image<std::uint8_t> readPgm(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw VectorError(path + ": cannot be opened");
  char magic[2] = {};
  if (!in.read(magic, 2) || magic[0] != 'P' || magic[1] != '5') {
    throw VectorError(path + ": not a binary PGM (P5)");
  }
  const int width = headerNumber(in, path, "width");
  const int height = headerNumber(in, path, "height");
  if (headerNumber(in, path, "maxval") != 255) throw VectorError(path + ": maxval is not 255");
  in.get();
  Image<std::uint8_t> image(width, height);
  const auto size = std::streamsize{width} * height;
  if (!in.read(reinterpret_cast<char*>(image.row(0)), size)) {
    throw VectorError(path + ": shorter than its header says");
  }
  return image;
}

void writePgm(const GrayView& image, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  out << "P5\n" << image.width << ' ' << image.height << "\n255\n";
  for (int v = 0; v < image.height; ++v) {
    out.write(reinterpret_cast<const char*>(image.row(v)), image.width);
  }
  if (!out.flush()) throw VectorError(path + ": cannot be written");
}

}  // namespace ipm_mapping::fpga
