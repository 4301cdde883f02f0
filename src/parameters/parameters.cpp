#include "ipm_mapping/parameters.hpp"

#include <cmath>

#include "ipm_mapping/io/nearest_name.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

/// The source's steps with only its outright errors mended.
Parameters paperProfile() {
  Parameters p;
  p.detector.kind = DetectorKind::Chain;
  p.reference.previous_frame = true;
  p.segmentation.previous_threshold = true;
  p.segmentation.min_threshold = 0;
  p.segmentation.min_separability = 0.0;
  p.localization.beam = Beam::Source;
  p.localization.mean_pixel_focus = true;
  p.localization.max_gap = 0;
  p.localization.lowest_minimum = false;
  p.localization.clipped_contacts = true;
  p.localization.single_bin_peaks = true;
  p.localization.selection = Selection::Peaks;
  p.localization.max_range = 2.0;
  p.fpga = FpgaParameters::paper();
  p.memory.hold = 0.0;
  p.map.update = MapUpdate::MarkOnce;
  return p;
}

}  // namespace

const std::vector<std::string>& Parameters::profileNames() {
  static const std::vector<std::string> names{"default", "paper", "first_architecture"};
  return names;
}

Parameters Parameters::profile(const std::string& name) {
  if (name == "default") return Parameters{};
  if (name == "paper") return paperProfile();
  if (name == "first_architecture") {
    Parameters p = paperProfile();
    p.detector.kind = DetectorKind::FirstArchitecture;
    return p;
  }
  std::string known;
  for (const std::string& each : profileNames()) known += (known.empty() ? "" : ", ") + each;
  throw ParameterError("profile '" + name + "' is not known; there are: " + known);
}

void Parameters::set(const std::string& group_and_field, const std::string& text) {
  bool found = false;
  std::vector<std::string> known;
  groups(*this, [&](const std::string& group, auto& fields) {
    forEachField(fields, [&](const std::string& field, auto& value, Unit, Range, const char*) {
      known.push_back(group + "/" + field);
      if (known.back() != group_and_field) return;
      setFromText(group_and_field, text, value);
      found = true;
    });
  });
  if (!found)
    throw ParameterError("there is no parameter '" + group_and_field + "'" +
                         didYouMean(group_and_field, known));
}

void Parameters::validate() const {
  groups(*this, [](const char* name, const auto& group) { validateFields(name, group); });
  if (map.free_below >= map.occupied_above)
    throw ParameterError("map/free_below has to be lower than map/occupied_above");
  if (memory.confirm_frames > memory.confirm_of)
    throw ParameterError("memory/confirm_frames may not exceed memory/confirm_of");
  const double surest = 1.0 / (1.0 + std::exp(-map.clamp));
  if (surest < map.occupied_above || 1.0 - surest > map.free_below)
    throw ParameterError("map/clamp = " + parameter_detail::numberText(map.clamp) +
                         ": no cell could ever reach map/occupied_above or map/free_below");
}

}  // namespace ipm_mapping
