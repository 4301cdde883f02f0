// Prints what the parameter structs say about themselves, or writes the files made from them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "ipm_mapping/io/atomic_file.hpp"
#include "ipm_mapping/io/parameters_document.hpp"
#include "ipm_mapping/io/parameters_yaml.hpp"

namespace {

constexpr int exit_usage = 2;
constexpr int exit_file = 3;

int complain(const std::string& what) {
  std::cerr << "describe_parameters: " << what << "\n";
  return exit_file;
}

/// 0 or an exit code.
int write(const std::string& root, const std::string& path, const std::string& text) {
  if (const auto error = ipm_mapping::writeFileAtomically(root + "/" + path, text))
    return complain(*error);
  std::cout << path << "\n";
  return 0;
}

int writeReadme(const std::string& root) {
  std::string readme;
  if (const auto error = ipm_mapping::readFile(root + "/README.md", readme))
    return complain(*error);
  const auto text = ipm_mapping::withGeneratedPart(readme, ipm_mapping::readmeParameters());
  return text ? write(root, "README.md", *text)
              : complain("README.md has no place for the parameters");
}

int writeGeneratedFiles(const std::string& root) {
  for (const auto& [path, text] : ipm_mapping::generatedFiles())
    if (const int code = write(root, path, text)) return code;
  return writeReadme(root);
}

/// The built-in profile that a printed file names as its base.
std::string baseOf(const std::string& profile) {
  const auto& names = ipm_mapping::Parameters::profileNames();
  return std::find(names.begin(), names.end(), profile) != names.end() ? profile : "default";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Describes the parameters of ipm_mapping"};
  std::string profile, root;
  bool markdown = false;
  auto* what = app.add_option_group("what");
  what->add_flag("--markdown", markdown, "print the reference as Markdown");
  what->add_option("--yaml", profile,
                   "print a complete profile file: default, paper, first_architecture, or a file");
  what->add_option(
      "--write", root,
      "write config/*.yaml, docs/parameters.md and the README's parameters below this folder (the "
      "repository)");
  what->require_option(1);
  try {
    app.parse(argc, argv);
    if (!root.empty()) return writeGeneratedFiles(root);
    if (markdown) std::cout << ipm_mapping::parametersMarkdown();
    if (!profile.empty())
      std::cout << ipm_mapping::parametersYaml(ipm_mapping::profileOrFile(profile),
                                               baseOf(profile));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : exit_usage;
  } catch (const ipm_mapping::ParameterError& error) {
    std::cerr << "describe_parameters: " << error.what() << "\n";
    return exit_usage;
  }
  return 0;
}
