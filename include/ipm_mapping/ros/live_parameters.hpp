#pragma once

#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <functional>
#include <string>
#include <vector>

#include "ipm_mapping/parameters.hpp"

namespace ipm_mapping {

/// Changes `parameters` as a dynamic_reconfigure request says; names are `group/field`. Numbers are
/// clamped to their range, as dynamic_reconfigure does. Nothing changes when the whole would
/// contradict itself. Returns one sentence for every entry that was not taken as it is.
std::vector<std::string> applyConfig(const dynamic_reconfigure::Config& config,
                                     const std::vector<std::string>& groups,
                                     Parameters& parameters);
/// The fields of the groups, as dynamic_reconfigure sends them.
[[nodiscard]] dynamic_reconfigure::Config toConfig(const Parameters& parameters,
                                                   const std::vector<std::string>& groups);
/// Names, types, units, ranges and choices of the fields.
[[nodiscard]] dynamic_reconfigure::ConfigDescription describe(
    const Parameters& defaults, const std::vector<std::string>& groups);

/// Parameters that rqt_reconfigure and dynparam can change while a nodelet runs: the
/// dynamic_reconfigure protocol spoken from the parameter structs themselves, so that names,
/// defaults and ranges stand in one place.
class LiveParameters {
 public:
  /// `changed` is called on the node's queue, between frames.
  LiveParameters(const ros::NodeHandle& private_node, const Parameters& parameters,
                 std::vector<std::string> groups, std::function<void(const Parameters&)> changed);

 private:
  bool onRequest(dynamic_reconfigure::Reconfigure::Request& request,
                 dynamic_reconfigure::Reconfigure::Response& response);
  void publish();

  ros::NodeHandle private_node_;
  Parameters parameters_;
  std::vector<std::string> groups_;
  std::function<void(const Parameters&)> changed_;
  ros::Publisher descriptions_, updates_;
  ros::ServiceServer service_;
};

}  // namespace ipm_mapping
