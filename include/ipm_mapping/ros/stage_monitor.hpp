#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/time.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/ros/fault_log.hpp"

namespace ipm_mapping {

/// Counts what becomes of a stage's input, says so on the console (each sentence at most every few
/// seconds) and on /diagnostics (every second of wall time, whatever the simulated clock does):
/// OK, WARN when input stays away or some of it is dropped, ERROR when nothing but faults came or
/// the stage could not start.
/// The status' sentence is the commonest fault; each of them, with how often it came since the
/// status before, is a value `fault_1`, `fault_2` ... ("3 times: sentence").
class StageMonitor {
 public:
  /// `name` as it shall stand in front of every sentence.
  StageMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node, std::string name);

  /// The stage stays idle for good, for this reason.
  void cannotStart(const std::string& sentence);
  /// A message came in; `what` names the topic for "nothing comes in on ...".
  void expect(const std::string& what) { expected_ = what; }
  void received();
  /// It was used; its latency counts up to now.
  void used(const ros::Time& stamp);
  /// It was answered, but is no new evidence for those that come after.
  void watched(const ros::Time& stamp, const std::string& sentence);
  /// It was left out for a reason that is no fault: the robot stands, history is filling.
  void skipped(const std::string& reason);
  /// It was dropped because something is wrong.
  void dropped(const std::string& reason, const std::string& sentence);
  /// Counts something that says nothing about the stage's health.
  void count(const std::string& reason) { ++counters_[reason]; }
  /// One sentence on the console, again after `repeat` seconds at the earliest.
  void warn(const std::string& sentence, double repeat = 5.0);
  /// Messages that were sent and never came: the network, or this process, is too slow for them.
  void lost(std::uint64_t messages);
  /// The same for the answer of a detector.
  void answered(FrameStatus status, const ros::Time& stamp, const std::string& sentence);

  /// A figure that diagnostics show.
  void set(const std::string& name, double value) { values_[name] = value; }
  /// A sentence that turns OK into WARN until it is taken back (empty). On the console as well, but
  /// rarely, for the figures in it may change with every frame.
  void setConcern(const std::string& sentence);
  /// Nobody listens: no input is no fault.
  void setAsleep(bool asleep) { asleep_ = asleep; }
  [[nodiscard]] std::uint64_t counter(const std::string& reason) const;

 private:
  struct Period {
    std::uint64_t received = 0, used = 0, skipped = 0, dropped = 0, lost = 0;
    std::optional<double> latency;
    std::string last_skip;
    FaultLog faults;
  };
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  void summarize(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  void listFaults(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  [[nodiscard]] bool timeToSay(const std::string& sentence, double repeat);

  std::string name_, expected_, concern_, cannot_start_;
  std::map<std::string, std::uint64_t> counters_;
  std::map<std::string, double> values_;
  std::map<std::string, ros::WallTime> said_;
  Period period_;
  ros::WallTime period_start_ = ros::WallTime::now();
  bool asleep_ = false;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace ipm_mapping
