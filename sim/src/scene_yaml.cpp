#include "ipm_mapping_sim/scene_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <type_traits>

namespace ipm_mapping::sim {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& value, const std::string& rule) {
  throw ParameterError("scene: " + path + " is " + value + ", must be " + rule);
}

std::string textOf(const YAML::Node& node) {
  std::ostringstream text;
  text << node;
  return text.str();
}

template <class T>
T scalar(const YAML::Node& node, const std::string& path, const char* what) {
  T value{};
  if (!node.IsScalar() || !YAML::convert<T>::decode(node, value)) fail(path, textOf(node), what);
  return value;
}

template <class T>
void readNumber(const YAML::Node& node, const std::string& path, const Range& range, T& value) {
  value = scalar<T>(node, path, std::is_integral_v<T> ? "a whole number" : "a number");
  if (range.contains(static_cast<double>(value))) return;
  std::ostringstream rule;
  rule << "in " << range.lowest << " ... " << range.highest;
  fail(path, textOf(node), rule.str());
}

void readValue(const YAML::Node& node, const std::string& path, std::string& value) {
  value = scalar<std::string>(node, path, "text");
}

void readValue(const YAML::Node& node, const std::string& path, double& value) {
  readNumber(node, path, Range{-1e9, 1e9}, value);
}

template <int N>
void readValue(const YAML::Node& node, const std::string& path,
               Eigen::Matrix<double, N, 1>& value) {
  if (!node.IsSequence() || node.size() != N) {
    fail(path, textOf(node), "a list of " + std::to_string(N) + " numbers");
  }
  for (int i = 0; i < N; ++i) {
    readValue(node[i], path + "[" + std::to_string(i) + "]", value[i]);
  }
}

template <class Enum>
std::enable_if_t<std::is_enum_v<Enum>> readValue(const YAML::Node& node, const std::string& path,
                                                 Enum& value) {
  const std::string word = scalar<std::string>(node, path, "a word");
  std::string allowed;
  for (std::size_t i = 0; i < enum_names<Enum>.size(); ++i) {
    if (word == enum_names<Enum>[i]) {
      value = static_cast<Enum>(i);
      return;
    }
    allowed += std::string(i == 0 ? "" : " | ") + enum_names<Enum>[i];
  }
  fail(path, word, allowed);
}

template <class Struct>
auto readValue(const YAML::Node& node, const std::string& path, Struct& value)
    -> std::void_t<decltype(&Struct::template fields<Struct, int>)>;

template <class T>
void readValue(const YAML::Node& node, const std::string& path, std::vector<T>& value) {
  if (!node.IsSequence()) fail(path, textOf(node), "a list");
  value.clear();
  value.resize(node.size());
  for (std::size_t i = 0; i < node.size(); ++i) {
    readValue(node[i], path + "[" + std::to_string(i) + "]", value[i]);
  }
}

/// Fills one struct from one mapping and remembers which entries it knew.
class StructReader {
 public:
  StructReader(const YAML::Node& node, std::string path) : node_(node), path_(std::move(path)) {}

  template <class T>
  void operator()(const char* name, T& value, Unit, Range range, const char*) {
    if (const YAML::Node entry = find(name)) readNumber(entry, pathOf(name), range, value);
  }
  template <class T>
  void operator()(const char* name, T& value, const char*) {
    if (const YAML::Node entry = find(name)) readValue(entry, pathOf(name), value);
  }

  void refuseUnknown() const {
    for (const auto& entry : node_) {
      const auto name = entry.first.as<std::string>();
      if (known_.count(name) == 0) fail(pathOf(name), "set", "one of the scene's known entries");
    }
  }

 private:
  YAML::Node find(const char* name) {
    known_.insert(name);
    return node_[name] ? node_[name] : YAML::Node(YAML::NodeType::Undefined);
  }
  [[nodiscard]] std::string pathOf(const std::string& name) const {
    return path_.empty() ? name : path_ + "." + name;
  }

  const YAML::Node node_;
  std::string path_;
  std::set<std::string> known_;
};

template <class Struct>
auto readValue(const YAML::Node& node, const std::string& path, Struct& value)
    -> std::void_t<decltype(&Struct::template fields<Struct, int>)> {
  if (!node.IsMap()) fail(path.empty() ? "the file" : path, textOf(node), "a mapping");
  StructReader reader(node, path);
  Struct::fields(value, reader);
  reader.refuseUnknown();
}

YAML::Node child(YAML::Node node, const std::string& key) {
  if (node.IsSequence()) return node[std::stoul(key)];
  return node[key];
}

void apply(YAML::Node root, const Override& change) {
  std::istringstream path(change.first);
  std::vector<YAML::Node> nodes{root};
  for (std::string key; std::getline(path, key, '.');) nodes.push_back(child(nodes.back(), key));
  nodes.back() = YAML::Load(change.second);
}

/// Entries of `change` over those of `base`; lists are replaced as a whole.
YAML::Node merged(const YAML::Node& base, const YAML::Node& change) {
  if (!base.IsMap() || !change.IsMap()) return change;
  YAML::Node all = YAML::Clone(base);
  for (const auto& entry : change) {
    const auto name = entry.first.as<std::string>();
    all[name] = base[name] ? merged(base[name], entry.second) : entry.second;
  }
  return all;
}

YAML::Node loadFile(const std::string& path, int depth = 0) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error("cannot read the scene " + path + ": " + error.what());
  }
  if (!root.IsMap() || !root["base"]) return root;
  if (depth > 8) fail("base", root["base"].as<std::string>(), "free of circles");
  const std::string folder = path.substr(0, path.find_last_of('/') + 1);
  const YAML::Node base = loadFile(folder + root["base"].as<std::string>(), depth + 1);
  root.remove("base");
  return merged(base, root);
}

Scene sceneFrom(const YAML::Node& root, const std::vector<Override>& overrides) {
  for (const Override& change : overrides) apply(root, change);
  Scene scene;
  readValue(root, "", scene);
  if (scene.rate <= 0.0 || scene.name.empty()) fail("name", "empty", "given");
  return scene;
}

// --- JSON ---------------------------------------------------------------------------------------

class JsonWriter {
 public:
  explicit JsonWriter(std::ostream& out) : out_(out) {}

  void write(double value) { out_ << value; }
  void write(int value) { out_ << value; }
  void write(const std::string& value) { out_ << '"' << value << '"'; }
  template <int N>
  void write(const Eigen::Matrix<double, N, 1>& value) {
    for (int i = 0; i < N; ++i) out_ << (i == 0 ? "[" : ", ") << value[i];
    out_ << "]";
  }
  template <class Enum>
  std::enable_if_t<std::is_enum_v<Enum>> write(Enum value) {
    write(std::string(enum_names<Enum>[static_cast<std::size_t>(value)]));
  }
  template <class T>
  void write(const std::vector<T>& values) {
    out_ << "[";
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) out_ << ", ";
      write(values[i]);
    }
    out_ << "]";
  }
  template <class Struct>
  auto write(const Struct& value) -> std::void_t<decltype(&Struct::template fields<Struct, int>)> {
    out_ << "{";
    bool first = true;
    const auto one = [&](const char* name, const auto& field, auto&&...) {
      out_ << (first ? "\"" : ", \"") << name << "\": ";
      first = false;
      write(field);
    };
    Struct::fields(value, one);
    out_ << "}";
  }

 private:
  std::ostream& out_;
};

}  // namespace

Scene loadScene(const std::string& path, const std::vector<Override>& overrides) {
  return sceneFrom(loadFile(path), overrides);
}

Scene parseScene(const std::string& text, const std::vector<Override>& overrides) {
  return sceneFrom(YAML::Load(text), overrides);
}

std::string sceneJson(const Scene& scene) {
  std::ostringstream out;
  out.precision(12);
  JsonWriter(out).write(scene);
  return out.str();
}

Point goneAlong(const std::vector<Waypoint>& way, double time) {
  if (way.empty()) return Point::Zero();
  const auto next = std::upper_bound(way.begin(), way.end(), time,
                                     [](double t, const Waypoint& w) { return t < w.at; });
  if (next == way.begin()) return {next->x, next->y};
  const Waypoint& last = *(next - 1);
  if (next == way.end()) return {last.x, last.y};
  const double t = (time - last.at) / (next->at - last.at);
  return {last.x + t * (next->x - last.x), last.y + t * (next->y - last.y)};
}

double driveDuration(const Scene& scene) {
  double seconds = 0.0;
  for (const DriveSegment& segment : scene.drive) seconds += segment.seconds;
  return seconds;
}

}  // namespace ipm_mapping::sim
