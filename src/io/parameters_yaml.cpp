#include "ipm_mapping/io/parameters_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <vector>

#include "ipm_mapping/io/atomic_file.hpp"
#include "ipm_mapping/io/nearest_name.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

/// One file being read: where messages say that something is.
class Reader {
 public:
  explicit Reader(const std::string& source) : source_(source) {}

  Parameters read(const std::string& text) const {
    YAML::Node file;
    try {
      file = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      throw ParameterError(source_ + ":" + std::to_string(error.mark.line + 1) + ": " + error.msg);
    }
    if (!file.IsMap() && !file.IsNull()) fail(file, "is not a map of parameter groups");
    Parameters parameters = base(file);
    requireDifferentNames(file);
    for (const auto& member : file)
      if (member.first.Scalar() != "profile") readGroup(member.first, member.second, parameters);
    validate(parameters);
    return parameters;
  }

 private:
  [[noreturn]] void fail(const YAML::Node& at, const std::string& words) const {
    throw ParameterError(source_ + ":" + std::to_string(at.Mark().line + 1) + ": " + words);
  }
  [[noreturn]] void failUnknown(const YAML::Node& at, const char* kind, const std::string& name,
                                const std::vector<std::string>& known) const {
    fail(at, std::string("there is no ") + kind + " '" + name + "'" + didYouMean(name, known));
  }

  [[nodiscard]] Parameters base(const YAML::Node& file) const {
    if (!file.IsMap() || !file["profile"]) return Parameters{};
    const YAML::Node name = file["profile"];
    const auto& known = Parameters::profileNames();
    if (!name.IsScalar() || std::find(known.begin(), known.end(), name.Scalar()) == known.end())
      failUnknown(name, "profile", name.IsScalar() ? name.Scalar() : "", known);
    return Parameters::profile(name.Scalar());
  }

  /// YAML would let the last of two silently win.
  void requireDifferentNames(const YAML::Node& map) const {
    std::set<std::string> names;
    for (const auto& member : map)
      if (!names.insert(member.first.Scalar()).second)
        fail(member.first, "'" + member.first.Scalar() + "' stands here twice");
  }

  void readGroup(const YAML::Node& key, const YAML::Node& fields, Parameters& parameters) const {
    const std::string& wanted = key.Scalar();
    std::vector<std::string> known;
    bool found = false;
    Parameters::groups(parameters, [&](const char* name, auto& group) {
      known.emplace_back(name);
      if (wanted != name) return;
      found = true;
      readFields(wanted, key, fields, group);
    });
    if (!found) failUnknown(key, "parameter group", wanted, known);
  }

  template <class Struct>
  void readFields(const std::string& group, const YAML::Node& key, const YAML::Node& fields,
                  Struct& parameters) const {
    if (fields.IsNull()) return;
    if (!fields.IsMap()) fail(key, "'" + group + "' has to be a map of parameters");
    requireDifferentNames(fields);
    for (const auto& member : fields) {
      const std::string path = group + "/" + member.first.Scalar();
      std::vector<std::string> known;
      bool found = false;
      forEachField(parameters, [&](const char* name, auto& value, Unit, Range, const char*) {
        known.push_back(group + "/" + name);
        if (path != known.back()) return;
        found = true;
        readValue(path, member.first, member.second, value);
      });
      if (!found) failUnknown(member.first, "parameter", path, known);
    }
  }

  template <class T>
  void readValue(const std::string& path, const YAML::Node& key, const YAML::Node& node,
                 T& value) const {
    if (!node.IsScalar()) fail(key, path + " needs a single value");
    try {
      setFromText(path, node.Scalar(), value);
    } catch (const ParameterError& error) {
      fail(key, error.what());
    }
  }

  void validate(const Parameters& parameters) const {
    try {
      parameters.validate();
    } catch (const ParameterError& error) {
      throw ParameterError(source_ + ": " + error.what());
    }
  }

  const std::string& source_;
};

constexpr std::size_t line_width = 96;

/// Words as comment lines.
std::string comment(const std::string& words, const std::string& indent) {
  std::istringstream in(words);
  std::string all, line = indent + "#", word;
  while (in >> word) {
    if (line.size() + 1 + word.size() > line_width) {
      all += line + "\n";
      line = indent + "#";
    }
    line += " " + word;
  }
  return all + line + "\n";
}

/// In single quotes, where only the quote itself has to be doubled.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

std::string entry(const FieldText& field) {
  std::string about = field.doc;
  if (!field.range.empty())
    about += " [" + field.range + (field.unit.empty() ? "" : " " + field.unit) + "]";
  const std::string value = field.type == "string" ? quoted(field.value) : field.value;
  return comment(about, "  ") + "  " + field.name + ": " + value + "\n";
}

}  // namespace

Parameters parseParametersYaml(const std::string& text, const std::string& source) {
  return Reader(source).read(text);
}

Parameters readParametersYaml(const std::string& path) {
  std::string text;
  if (const auto error = readFile(path, text)) throw ParameterError(*error);
  return parseParametersYaml(text, path);
}

Parameters profileOrFile(const std::string& name_or_path) {
  const auto& names = Parameters::profileNames();
  const bool built_in = std::find(names.begin(), names.end(), name_or_path) != names.end();
  const bool path = name_or_path.find_first_of("./") != std::string::npos;
  return built_in || !path ? Parameters::profile(name_or_path) : readParametersYaml(name_or_path);
}

std::string parametersYaml(const Parameters& parameters, const std::string& profile) {
  std::string yaml = "profile: " + profile + "\n";
  Parameters::groups(parameters, [&yaml](const char* name, const auto& group) {
    yaml += std::string("\n") + name + ":\n";
    describeFields(group, [&yaml](const FieldText& field) { yaml += entry(field); });
  });
  return yaml;
}

}  // namespace ipm_mapping
