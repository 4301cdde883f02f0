#include "ipm_mapping/io/parameters_document.hpp"

#include <vector>

#include "ipm_mapping/io/parameters_yaml.hpp"
#include "ipm_mapping/parameters/comparison_parameters.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

constexpr const char* generated_begin = "<!-- parameters: written by describe_parameters";
constexpr const char* generated_end = "<!-- end of the parameters -->";

constexpr const char* introduction =
    "# Parameters\n\n"
    "Written by `describe_parameters` from the structs in `include/ipm_mapping/parameters`, which "
    "hold the only copy of every default; a test compares.\n\n"
    "Nodelets read `~GROUP/NAME` below their private namespace, on top of the profile that "
    "`~profile` names: `default`, `paper`, `first_architecture`, or the path of a file like those "
    "in `config/`. `offline_mapper` takes the same with `--profile`, and single values with "
    "`--set GROUP/NAME=VALUE`. A value outside its range is refused by name; one "
    "that is set live is moved into it, as dynamic_reconfigure does, with a warning.\n";

/// A bar would end the table's cell.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}
std::string code(const std::string& text) { return text.empty() ? "" : "`" + cell(text) + "`"; }

std::string parameterRow(const std::string& name, const FieldText& f) {
  return "| " + code(name) + " | " + f.type + " | " + code(f.value) + " | " + cell(f.unit) + " | " +
         cell(f.range) + " | " + cell(f.doc) + " |\n";
}

template <class Struct>
std::string table(const Struct& parameters) {
  std::string rows =
      "| name | type | default | unit | allowed | meaning |\n|---|---|---|---|---|---|\n";
  describeFields(parameters, [&rows](const FieldText& f) { rows += parameterRow(f.name, f); });
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

/// What somebody with a robot of his own sets before anything else, in the order of the work.
const std::vector<const char*> first_touched{"profile",
                                             "detector/kind",
                                             "camera/pose_from_tf",
                                             "camera/x",
                                             "camera/y",
                                             "camera/z",
                                             "camera/pitch",
                                             "camera/calibration_file",
                                             "camera/image_time_offset",
                                             "image_transport",
                                             "base_frame",
                                             "odom_frame",
                                             "odometry_source",
                                             "sweep/max_range",
                                             "sweep/publish_score",
                                             "sweep/short_baseline",
                                             "reference/min_baseline",
                                             "segmentation/min_threshold",
                                             "output/contact_z",
                                             "map/resolution",
                                             "map/hit",
                                             "map/miss",
                                             "directory",
                                             "initial_map",
                                             "autosave_period",
                                             "clear_on_clock_jump"};

template <class Struct>
void describeInto(std::map<std::string, FieldText>& all, const std::string& prefix,
                  const Struct& parameters) {
  describeFields(parameters, [&](const FieldText& f) { all.emplace(prefix + f.name, f); });
}

/// By what stands behind the `~`.
std::map<std::string, FieldText> everyParameter() {
  const Parameters defaults;
  std::map<std::string, FieldText> all;
  Parameters::groups(defaults, [&](const char* name, const auto& group) {
    describeInto(all, std::string(name) + "/", group);
  });
  describeInto(all, "", SourceParameters{});
  describeInto(all, "", FloorLocaliserParameters{});
  describeInto(all, "", TransportParameters{});
  describeInto(all, "", MapperParameters{});
  return all;
}

/// Throws std::out_of_range when a name of `first_touched` is no parameter any more.
std::string firstTable() {
  auto all = everyParameter();
  std::string profiles;
  for (const std::string& name : Parameters::profileNames())
    profiles += (profiles.empty() ? "" : " | ") + name;
  all["profile"] = {"profile",
                    "string",
                    "",
                    Parameters::profileNames().front(),
                    profiles + " | a file",
                    "the values that all others start from"};
  std::string rows =
      "| parameter | type | default | unit | allowed | meaning |\n|---|---|---|---|---|---|\n";
  for (const char* name : first_touched)
    rows += parameterRow("~" + std::string(name), all.at(name));
  return rows;
}

std::string parameterTables(const std::string& heading) {
  std::string text;
  const auto add = [&](const std::string& title, const std::string& content) {
    text += "\n" + heading + " " + title + "\n\n" + content;
  };
  const Parameters defaults;
  Parameters::groups(defaults,
                     [&](const char* name, const auto& group) { add(name, table(group)); });
  add("What the profiles change", profileTable());
  add("Nodelets that start from camera images (`~NAME`)", table(SourceParameters{}));
  add("Detectors in one piece (`~NAME`)", table(FloorLocaliserParameters{}));
  add("Nodelets that take or draw on camera images (`~NAME`)", table(TransportParameters{}));
  add("Nodelets between two others (`~NAME`)", table(StageParameters{}));
  add("Mapper (`~NAME`)", table(MapperParameters{}));
  add("Comparison (`~NAME`)", table(ComparisonParameters{}));
  return text;
}

}  // namespace

std::string parametersMarkdown() { return introduction + parameterTables("##"); }

std::string readmeParameters() {
  return "\n" + firstTable() +
         "\n<details>\n<summary><b>Every parameter of every nodelet</b></summary>\n" +
         parameterTables("####") + "\n</details>\n\n";
}

std::optional<std::string> withGeneratedPart(const std::string& text, const std::string& part) {
  const std::size_t mark = text.find(generated_begin), end = text.find(generated_end);
  if (mark == std::string::npos || end == std::string::npos || end < mark) return std::nullopt;
  const std::size_t begin = text.find('\n', mark) + 1;
  return text.substr(0, begin) + part + text.substr(end);
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
