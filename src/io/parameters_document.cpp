#include "ipm_mapping/io/parameters_document.hpp"

#include <vector>

#include "ipm_mapping/io/parameters_yaml.hpp"
#include "ipm_mapping/parameters/comparison_parameters.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

constexpr const char* introduction =
    "# Parameters\n\n"
    "Written by `describe_parameters` from the structs in `include/ipm_mapping/parameters`, which "
    "hold the only copy of every default; a test compares.\n\n"
    "Nodelets read `~GROUP/NAME` below their private namespace, on top of the profile that "
    "`~profile` names: `default`, `paper`, `first_architecture`, or the path of a file like those "
    "in `config/`. `offline_mapper` takes the same with `--profile`, and single values with "
    "`--set GROUP/NAME=VALUE`. A value outside its range is refused by name.\n";

/// A bar would end the table's cell.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}
std::string code(const std::string& text) { return text.empty() ? "" : "`" + cell(text) + "`"; }

template <class Struct>
std::string table(const Struct& parameters) {
  std::string rows =
      "| name | type | default | unit | allowed | meaning |\n|---|---|---|---|---|---|\n";
  describeFields(parameters, [&rows](const FieldText& f) {
    rows += "| " + code(f.name) + " | " + f.type + " | " + code(f.value) + " | " + cell(f.unit) +
            " | " + cell(f.range) + " | " + cell(f.doc) + " |\n";
  });
  return rows;
}

std::map<std::string, std::string> valuesOf(const std::string& profile) {
  std::map<std::string, std::string> values;
  const Parameters parameters = Parameters::profile(profile);
  Parameters::groups(parameters, [&](const char* name, const auto& group) {
    describeFields(group, [&](const FieldText& field) {
      values[std::string(name) + "/" + field.name] = field.value;
    });
  });
  return values;
}

/// One row for every parameter that some profile sets otherwise than `default`.
std::string profileTable() {
  std::vector<std::map<std::string, std::string>> values;
  std::string rows = "| parameter |", rule = "\n|---|";
  for (const std::string& profile : Parameters::profileNames()) {
    values.push_back(valuesOf(profile));
    rows += " " + code(profile) + " |";
    rule += "---|";
  }
  rows += rule + "\n";
  for (const auto& [name, value] : values.front()) {
    bool differs = false;
    std::string row = "| " + code(name) + " |";
    for (const auto& each : values) {
      differs = differs || each.at(name) != value;
      row += " " + code(each.at(name)) + " |";
    }
    if (differs) rows += row + "\n";
  }
  return rows;
}

}  // namespace

std::string parametersMarkdown() {
  std::string text = introduction;
  const Parameters defaults;
  Parameters::groups(defaults, [&text](const char* name, const auto& group) {
    text += std::string("\n## ") + name + "\n\n" + table(group);
  });
  text += "\n## What the profiles change\n\n" + profileTable();
  text += "\n## Nodelets that start from camera images (`~NAME`)\n\n" + table(SourceParameters{});
  text += "\n## Nodelets that take or draw on camera images (`~NAME`)\n\n" +
          table(TransportParameters{});
  text += "\n## Nodelets between two others (`~NAME`)\n\n" + table(StageParameters{});
  text += "\n## Mapper (`~NAME`)\n\n" + table(MapperParameters{});
  text += "\n## Comparison (`~NAME`)\n\n" + table(ComparisonParameters{});
  return text;
}

std::map<std::string, std::string> generatedFiles() {
  std::map<std::string, std::string> files{{"docs/parameters.md", parametersMarkdown()}};
  for (const std::string& profile : Parameters::profileNames())
    files["config/" + profile + ".yaml"] =
        "# Written by describe_parameters; copy it, keep what you change, and pass the copy as the "
        "profile.\n" +
        parametersYaml(Parameters::profile(profile), profile);
  return files;
}

}  // namespace ipm_mapping
