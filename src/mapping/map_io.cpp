#include "ipm_mapping/mapping/map_io.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "ipm_mapping/io/atomic_file.hpp"

namespace ipm_mapping {
namespace {

// What map_server writes and, with negate 0, reads.
constexpr char occupied_pixel = 0;
constexpr char free_pixel = static_cast<char>(254);
constexpr char unknown_pixel = static_cast<char>(205);
// Of the picture that is named while STEM.pgm changes. No map of another name has such a picture.
constexpr const char* staged_suffix = ".new";
constexpr const char* thresholds = "occupied_thresh: 0.65\nfree_thresh: 0.196\n";

char pixelOf(std::int8_t occupancy) {
  if (occupancy == 0) return free_pixel;
  return occupancy == 100 ? occupied_pixel : unknown_pixel;
}

std::string pgmOf(const TrinaryMap& map) {
  std::string pgm =
      "P5\n" + std::to_string(map.width) + " " + std::to_string(map.height) + "\n255\n";
  for (int y = map.height - 1; y >= 0; --y)
    for (int x = 0; x < map.width; ++x)
      pgm += pixelOf(map.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                               static_cast<std::size_t>(x)]);
  return pgm;
}

/// Twelve digits: exact to a nanometre over a kilometre, and 0.05 stays 0.05.
std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", value);
  return text;
}

/// A name as YAML takes it for a text whatever is in it; plain where it may be.
std::string text(const std::string& name) {
  YAML::Emitter out;
  out << name;
  return out.c_str();
}

std::string yamlOf(const TrinaryMap& map, const std::string& image) {
  return "image: " + text(image) + "\nresolution: " + number(map.resolution) + "\norigin: [" +
         number(map.origin_x) + ", " + number(map.origin_y) + ", 0]\nnegate: 0\n" + thresholds;
}

/// What a map_server YAML says beside the picture.
struct MapDescription {
  std::string image;
  double resolution, x, y, yaw, occupied, free;
  bool negate;
};

/// Thrown inside the loader only, with a sentence that says what is wrong.
using Unreadable = std::runtime_error;

template <class T>
T required(const YAML::Node& yaml, const char* key) {
  if (!yaml[key]) throw Unreadable(std::string("'") + key + "' is missing");
  try {
    return yaml[key].as<T>();
  } catch (const YAML::Exception&) {
    throw Unreadable(std::string("'") + key + "' is not what map_server writes there");
  }
}

MapDescription describe(const std::string& text) {
  const YAML::Node yaml = YAML::Load(text);
  if (!yaml.IsMap()) throw Unreadable("is not a map_server YAML");
  const auto origin = required<std::vector<double>>(yaml, "origin");
  if (origin.size() != 3) throw Unreadable("'origin' needs three numbers: x, y, yaw");
  MapDescription d{required<std::string>(yaml, "image"),
                   required<double>(yaml, "resolution"),
                   origin[0],
                   origin[1],
                   origin[2],
                   required<double>(yaml, "occupied_thresh"),
                   required<double>(yaml, "free_thresh"),
                   required<int>(yaml, "negate") != 0};
  if (!(d.resolution > 0.0) || !std::isfinite(d.resolution))
    throw Unreadable("'resolution' has to be positive");
  if (!std::isfinite(d.x) || !std::isfinite(d.y)) throw Unreadable("'origin' is not finite");
  if (d.yaw != 0.0) throw Unreadable("'origin' has a rotation: turned maps are not supported");
  if (yaml["mode"] && yaml["mode"].as<std::string>() != "trinary")
    throw Unreadable("'mode' is '" + yaml["mode"].as<std::string>() + "', supported is 'trinary'");
  return d;
}

/// A PGM file being read: header tokens separated by blanks and comments, then the pixels.
class PgmReader {
 public:
  explicit PgmReader(const std::string& bytes) : bytes_(bytes) {}

  std::string token() {
    skipBlanks();
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !blank(bytes_[at_])) ++at_;
    return bytes_.substr(begin, at_ - begin);
  }
  int positive(const char* what) {
    const std::string text = token();
    long value = 0;
    for (const char c : text) {
      if (c < '0' || c > '9' || value > std::numeric_limits<int>::max() / 10)
        throw Unreadable(std::string(what) + " '" + text + "' is not a number");
      value = value * 10 + (c - '0');
    }
    if (text.empty()) throw Unreadable(std::string("ends before its ") + what);
    return static_cast<int>(value);
  }
  /// The byte after the single blank behind the header.
  int binaryPixel() {
    if (!in_pixels_) ++at_;
    in_pixels_ = true;
    if (at_ >= bytes_.size()) throw Unreadable("ends before its last pixel");
    return static_cast<unsigned char>(bytes_[at_++]);
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  static bool blank(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  void skipBlanks() {
    for (; at_ < bytes_.size() && (blank(bytes_[at_]) || bytes_[at_] == '#'); ++at_)
      if (bytes_[at_] == '#') at_ = std::min(bytes_.find('\n', at_), bytes_.size() - 1);
  }

  const std::string& bytes_;
  std::size_t at_ = 0;
  bool in_pixels_ = false;
};

/// map_server's trinary interpretation of one pixel.
std::int8_t occupancyOf(int pixel, int white, const MapDescription& d) {
  const double brightness = static_cast<double>(pixel) / white;
  const double p = d.negate ? brightness : 1.0 - brightness;
  if (p > d.occupied) return 100;
  return p < d.free ? 0 : -1;
}

TrinaryMap mapOf(const std::string& pgm, const MapDescription& d) {
  PgmReader reader(pgm);
  const std::string kind = reader.token();
  if (kind != "P5" && kind != "P2") throw Unreadable("is not a PGM picture (P5 or P2)");
  TrinaryMap map;
  map.resolution = d.resolution;
  map.origin_x = d.x;
  map.origin_y = d.y;
  map.width = reader.positive("width");
  map.height = reader.positive("height");
  const int white = reader.positive("maximum");
  if (white < 1 || white > 255) throw Unreadable("has more than 8 bits a pixel");
  const auto width = static_cast<std::size_t>(map.width);
  const std::size_t size = width * static_cast<std::size_t>(map.height);
  if (size == 0 || size > reader.left()) throw Unreadable("is smaller than its header says");
  map.cells.resize(size);
  for (std::size_t row = 0; row < static_cast<std::size_t>(map.height); ++row)
    for (std::size_t x = 0; x < width; ++x) {
      const int pixel = kind == "P5" ? reader.binaryPixel() : reader.positive("pixel");
      map.cells[(static_cast<std::size_t>(map.height) - 1 - row) * width + x] =
          occupancyOf(pixel, white, d);
    }
  return map;
}

/// Runs `step`; what it throws becomes a sentence that starts with the file's name.
template <class Step>
std::optional<std::string> inFile(const std::string& path, Step&& step) {
  try {
    step();
    return std::nullopt;
  } catch (const std::exception& e) {
    return path + ": " + e.what();
  }
}

std::string fileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// Whether a map_server YAML can be read and its picture is `picture`, in the same folder.
bool namesPicture(const std::string& yaml_path, const std::string& picture) {
  std::string text;
  if (readFile(yaml_path, text)) return false;
  try {
    return describe(text).image == fileName(picture);
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

std::optional<std::string> saveMap(const TrinaryMap& map, const std::string& stem) {
  if (map.width <= 0 || map.height <= 0) return stem + ".pgm: the map has no cells yet";
  const std::string pgm = pgmOf(map);
  const std::string picture = stem + ".pgm", yaml = stem + ".yaml";
  const std::string staged = picture + staged_suffix;
  std::error_code ignored;
  // Killed between the two renames, a new picture would stand at the old origin. So the YAML names
  // a picture beside STEM.pgm while that one changes; it does already if the last save was killed.
  if (!namesPicture(yaml, staged)) {
    if (auto error = writeFileAtomically(staged, pgm)) return error;
    if (auto error = writeFileAtomically(yaml, yamlOf(map, fileName(staged)))) {
      std::filesystem::remove(staged, ignored);
      return error;
    }
  }
  if (auto error = writeFileAtomically(picture, pgm)) return error;
  if (auto error = writeFileAtomically(yaml, yamlOf(map, fileName(picture)))) return error;
  std::filesystem::remove(staged, ignored);
  return std::nullopt;
}

std::optional<std::string> loadMap(const std::string& yaml_path, TrinaryMap& map) {
  std::string text, pgm;
  MapDescription description;
  if (auto error = readFile(yaml_path, text)) return error;
  if (auto error = inFile(yaml_path, [&] { description = describe(text); })) return error;
  const auto image = std::filesystem::path(yaml_path).parent_path() / description.image;
  if (auto error = readFile(image.string(), pgm)) return error;
  return inFile(image.string(), [&] { map = mapOf(pgm, description); });
}

}  // namespace ipm_mapping
