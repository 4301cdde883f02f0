#include "ipm_mapping/io/parameters_document.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

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

TEST(ParametersDocument, TheReadmeSaysWhatTheStructsSay) {
  std::string readme;
  ASSERT_EQ(readFile(std::string(SOURCE_DIRECTORY) + "/README.md", readme), std::nullopt);
  const auto expected = withGeneratedPart(readme, readmeParameters());
  ASSERT_TRUE(expected) << "the README has no place for the parameters";
  EXPECT_EQ(readme, *expected)
      << "README.md is out of date; write it anew from the root of the repository with\n"
      << "  ./scripts/env rosrun ipm_mapping describe_parameters --write .";
}

TEST(ParametersDocument, TheReadmeHasEveryParameterAndWhatComesFirstTwice) {
  const std::string text = readmeParameters();
  const std::size_t folded = text.find("<details>");
  ASSERT_NE(folded, std::string::npos);
  const auto row = [](const std::string& name, const FieldText& f) {
    return "\n| `" + name + "` | " + f.type + " | " + (f.value.empty() ? "" : "`" + f.value + "`") +
           " | " + f.unit + " | ";
  };
  const Parameters defaults;
  Parameters::groups(defaults, [&](const char* name, const auto& group) {
    const std::size_t begin = text.find(std::string("\n#### ") + name + "\n", folded);
    ASSERT_NE(begin, std::string::npos) << name;
    describeFields(group, [&](const FieldText& f) {
      EXPECT_NE(text.find(row(f.name, f), begin), std::string::npos) << name << "/" << f.name;
    });
  });
  describeFields(CameraParameters{}, [&](const FieldText& f) {
    const bool first = f.name == "z" || f.name == "pitch" || f.name == "image_time_offset";
    EXPECT_TRUE(!first || text.find(row("~camera/" + f.name, f)) < folded) << f.name;
  });
}

/// GROUP/NAME of every code span of a page that looks like one: `map/hit`, `map/hit=2`, `~map/hit`.
std::set<std::string> parametersNamedIn(const std::string& page) {
  std::set<std::string> groups, named;
  const Parameters defaults;
  Parameters::groups(defaults, [&](const char* name, const auto&) { groups.insert(name); });
  const std::regex span("`~?([a-z_]+)/([a-z_]+)(=[^`]*)?`");
  for (auto it = std::sregex_iterator(page.begin(), page.end(), span); it != std::sregex_iterator();
       ++it)
    if (groups.count((*it)[1]) > 0) named.insert((*it)[1].str() + "/" + (*it)[2].str());
  return named;
}

TEST(ParametersDocument, EveryParameterThatAPageNamesExists) {
  std::set<std::string> known;
  const Parameters defaults;
  Parameters::groups(defaults, [&](const char* name, const auto& group) {
    describeFields(group,
                   [&](const FieldText& f) { known.insert(std::string(name) + "/" + f.name); });
  });
  std::size_t count = 0;
  for (const char* page :
       {"README.md", "docs/tuning.md", "docs/robot.md", "docs/accuracy.md", "docs/sweep.md"}) {
    std::string text;
    ASSERT_EQ(readFile(std::string(SOURCE_DIRECTORY) + "/" + page, text), std::nullopt);
    for (const std::string& name : parametersNamedIn(text)) {
      EXPECT_EQ(known.count(name), 1U) << page << " names " << name;
      ++count;
    }
  }
  EXPECT_GT(count, 20U);
}

TEST(ParametersDocument, OnlyWhatStandsBetweenTheMarksIsReplaced) {
  const std::string before = "a\n<!-- parameters: written by describe_parameters -->\n",
                    after = "<!-- end of the parameters -->\nb\n";
  EXPECT_EQ(withGeneratedPart(before + "old\nrows\n" + after, "new\n"), before + "new\n" + after);
  EXPECT_EQ(withGeneratedPart(before + after, "new\n"), before + "new\n" + after);
  EXPECT_EQ(withGeneratedPart(before, "new\n"), std::nullopt);
  EXPECT_EQ(withGeneratedPart(after + before, "new\n"), std::nullopt);
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
  std::istringstream in(parametersMarkdown() + readmeParameters());
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
