#include "ipm_mapping/io/parameters_document.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/io/atomic_file.hpp"
#include "ipm_mapping/io/parameters_yaml.hpp"
#include "ipm_mapping/parameters/comparison_parameters.hpp"
#include "ipm_mapping/parameters/node_parameters.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

TEST(ParametersDocument, FilesInTheRepositoryAreWhatTheStructsSay) {
  const auto files = generatedFiles();
  EXPECT_EQ(files.size(), Parameters::profileNames().size() + 1);
  for (const auto& [path, expected] : files) {
    std::string content;
    ASSERT_EQ(readFile(std::string(SOURCE_DIRECTORY) + "/" + path, content), std::nullopt);
    EXPECT_EQ(content, expected)
        << path << " is out of date; write it anew from the root of the repository with\n"
        << "  ./scripts/env rosrun ipm_mapping describe_parameters --write .";
  }
}

TEST(ParametersDocument, EveryProfileFileReadsAsItsProfile) {
  for (const std::string& profile : Parameters::profileNames()) {
    const std::string path = std::string(SOURCE_DIRECTORY) + "/config/" + profile + ".yaml";
    EXPECT_EQ(parametersYaml(readParametersYaml(path), profile),
              parametersYaml(Parameters::profile(profile), profile));
  }
}

TEST(ParametersDocument, HasARowForEveryParameter) {
  const std::string text = parametersMarkdown();
  const Parameters parameters;
  Parameters::groups(parameters, [&text](const char* name, const auto& group) {
    const std::size_t begin = text.find(std::string("\n## ") + name + "\n");
    ASSERT_NE(begin, std::string::npos) << name;
    const std::string section = text.substr(begin, text.find("\n## ", begin + 1) - begin);
    describeFields(group, [&](const FieldText& field) {
      EXPECT_NE(section.find("\n| `" + field.name + "` | " + field.type + " | "), std::string::npos)
          << name << "/" << field.name;
    });
  });
}

template <class Struct>
void expectRows(const std::string& section) {
  describeFields(Struct{}, [&](const FieldText& field) {
    EXPECT_NE(section.find("\n| `" + field.name + "` | " + field.type + " | "), std::string::npos)
        << field.name;
  });
}

TEST(ParametersDocument, HasARowForWhatStandsDirectlyInTheNodeletsNamespace) {
  const std::string text = parametersMarkdown();
  const std::size_t begin = text.find("\n## Nodelets that start");
  ASSERT_NE(begin, std::string::npos);
  const std::string section = text.substr(begin);
  expectRows<SourceParameters>(section);
  expectRows<TransportParameters>(section);
  expectRows<StageParameters>(section);
  expectRows<MapperParameters>(section);
  expectRows<ComparisonParameters>(section);
}

TEST(ParametersDocument, TablesAreNotBrokenByBarsInTheText) {
  std::istringstream in(parametersMarkdown());
  std::size_t columns = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] != '|') {
      columns = 0;
      continue;
    }
    std::size_t bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i)
      bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    if (columns == 0) columns = bars;
    EXPECT_EQ(bars, columns) << line;
  }
}

TEST(ParametersDocument, TheProfileTableListsWhatDiffers) {
  const std::string text = parametersMarkdown();
  EXPECT_NE(text.find("| `map/update` | `log_odds` | `mark_once` |"), std::string::npos);
  EXPECT_EQ(text.find("| `map/resolution` | `0.05` |"), std::string::npos);
}

}  // namespace
}  // namespace ipm_mapping
