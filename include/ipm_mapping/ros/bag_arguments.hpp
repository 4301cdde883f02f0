#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "ipm_mapping/ros/offline_run.hpp"

namespace ipm_mapping {

/// Exit codes of the command line tools.
inline constexpr int exit_usage = 2;  ///< wrong usage
inline constexpr int exit_input = 3;  ///< input unreadable or missing

/// What every tool that reads a bag can be told.
struct BagArguments {
  OfflineOptions options;
  std::string profile = "default";
  std::vector<std::string> settings;
  std::vector<double> camera_pose;

  /// Declares the options (not the bag itself).
  void declare(CLI::App& app);
  /// Turns the texts into options; throws ParameterError.
  void settle();
};

/// For options that take a number above 0.
[[nodiscard]] CLI::Validator positiveNumber();

/// One line; none without words.
void printWarning(std::ostream& out, const std::string& words);

/// main() of a tool: parses, settles, works; every failure becomes one line and an exit code.
int runTool(CLI::App& app, const char* name, int argc, char** argv,
            const std::function<void()>& settle, const std::function<void()>& work);

}  // namespace ipm_mapping
