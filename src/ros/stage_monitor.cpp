#include "ipm_mapping/ros/stage_monitor.hpp"

#include <ros/console.h>

#include <algorithm>
#include <utility>

namespace ipm_mapping {
namespace {

constexpr double repeat_error_seconds = 5.0, repeat_concern_seconds = 60.0;
constexpr std::size_t remembered_sentences = 64;

using diagnostic_msgs::DiagnosticStatus;

}  // namespace

StageMonitor::StageMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                           std::string name)
    : name_(std::move(name)), updater_(node, private_node, name_) {
  updater_.setHardwareID("none");
  updater_.add("frames", this, &StageMonitor::report);
  timer_ = node.createWallTimer(ros::WallDuration(1.0),
                                [this](const ros::WallTimerEvent&) { updater_.force_update(); });
}

void StageMonitor::cannotStart(const std::string& sentence) {
  cannot_start_ = "cannot start and stays idle: " + sentence;
  ROS_FATAL_STREAM(name_ << ": " << cannot_start_);
}

void StageMonitor::received() {
  ++counters_["received"];
  ++period_.received;
}

void StageMonitor::used(const ros::Time& stamp) {
  ++counters_["used"];
  ++period_.used;
  period_.latency = std::max(0.0, (ros::Time::now() - stamp).toSec());
}

void StageMonitor::watched(const ros::Time& stamp, const std::string& sentence) {
  ++counters_["watched"];
  ++period_.skipped;
  period_.last_skip = sentence;
  period_.latency = std::max(0.0, (ros::Time::now() - stamp).toSec());
}

void StageMonitor::skipped(const std::string& reason) {
  ++counters_["skipped_" + reason];
  ++period_.skipped;
  period_.last_skip = reason;
}

void StageMonitor::dropped(const std::string& reason, const std::string& sentence) {
  ++counters_["dropped_" + reason];
  ++period_.dropped;
  period_.faults.add(sentence);
  if (timeToSay(sentence, repeat_error_seconds)) ROS_ERROR_STREAM(name_ << ": " << sentence);
}

void StageMonitor::warn(const std::string& sentence, double repeat) {
  if (timeToSay(sentence, repeat)) ROS_WARN_STREAM(name_ << ": " << sentence);
}

void StageMonitor::lost(std::uint64_t messages) {
  if (messages == 0) return;
  counters_["lost_before_arrival"] += messages;
  period_.lost += messages;
}

void StageMonitor::answered(FrameStatus status, const ros::Time& stamp,
                            const std::string& sentence) {
  if (status == FrameStatus::Used) return used(stamp);
  if (status == FrameStatus::Watched) return watched(stamp, sentence);
  if (!isFault(status)) return skipped(ipm_mapping::name(status));
  dropped(ipm_mapping::name(status), sentence);
}

void StageMonitor::setConcern(const std::string& sentence) {
  concern_ = sentence;
  if (!sentence.empty() && timeToSay("the concern", repeat_concern_seconds))
    ROS_WARN_STREAM(name_ << ": " << sentence);
}

std::uint64_t StageMonitor::counter(const std::string& reason) const {
  const auto found = counters_.find(reason);
  return found == counters_.end() ? 0 : found->second;
}

bool StageMonitor::timeToSay(const std::string& sentence, double repeat) {
  const ros::WallTime now = ros::WallTime::now();
  if (said_.size() > remembered_sentences) said_.clear();
  ros::WallTime& last = said_[sentence];
  if ((now - last).toSec() < repeat) return false;
  last = now;
  return true;
}

void StageMonitor::summarize(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  if (!cannot_start_.empty())
    status.summary(DiagnosticStatus::ERROR, cannot_start_);
  else if (asleep_)
    status.summary(DiagnosticStatus::OK, "asleep: nobody listens");
  else if (period_.dropped > 0)
    status.summary(period_.used > 0 ? DiagnosticStatus::WARN : DiagnosticStatus::ERROR,
                   period_.faults.commonest());
  else if (period_.received == 0)
    status.summary(DiagnosticStatus::WARN, "nothing comes in on " + expected_);
  else if (period_.lost > 0)
    status.summary(DiagnosticStatus::WARN,
                   std::to_string(period_.lost) + " messages on " + expected_ +
                       " never came: the network or this process is too slow for them");
  else if (!concern_.empty())
    status.summary(DiagnosticStatus::WARN, concern_);
  else if (period_.used == 0 && period_.skipped > 0)
    status.summary(DiagnosticStatus::OK, "no new evidence: " + period_.last_skip);
  else if (period_.used == 0)
    status.summary(DiagnosticStatus::WARN, "frames wait");
  else
    status.summary(DiagnosticStatus::OK, "frames are used");
}

void StageMonitor::listFaults(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  int number = 0;
  for (const FaultLog::Fault& fault : period_.faults.faults())
    status.add("fault_" + std::to_string(++number),
               std::to_string(fault.count) + " times: " + fault.sentence);
  if (period_.faults.others() > 0) status.add("other_faults", period_.faults.others());
}

void StageMonitor::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const ros::WallTime now = ros::WallTime::now();
  const double seconds = (now - period_start_).toSec();
  summarize(status);
  listFaults(status);
  status.addf("input_rate_hz", "%.2f", static_cast<double>(period_.received) / seconds);
  status.addf("used_rate_hz", "%.2f", static_cast<double>(period_.used) / seconds);
  if (period_.latency) status.addf("latency_s", "%.4f", *period_.latency);
  for (const auto& [name, value] : values_) status.addf(name, "%g", value);
  for (const auto& [name, value] : counters_) status.add(name, value);
  period_ = {};
  period_start_ = now;
}

}  // namespace ipm_mapping
