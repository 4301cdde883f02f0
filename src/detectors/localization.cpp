#include "ipm_mapping/detectors/localization.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {
double effectiveMaxRange(double parameter, const CameraModel& camera,
                         const CameraPose& T_base_camera) {
  if (parameter > 0.0) return parameter;
  const double near = nearestVisibleFloor(camera, T_base_camera);
  return std::isfinite(near) ? std::max(2.0, 3.0 * near) : 2.0;
}

std::optional<LineStop> Localization::stopOf(int line) const {
  const LineContacts& found = lines_[static_cast<std::size_t>(line)];
  const TriangleContact* contact =
      found.nearest < 0 ? nullptr : &finder_.contacts()[static_cast<std::size_t>(found.nearest)];
  // What stands nearer to the robot on the line, a contact or a blob without one, decides.
  if (found.blocked_row >= 0 && (contact == nullptr || found.blocked_row > contact->v))
    return LineStop{beam_.columns(line)[found.blocked_row], found.blocked_row,
                    BearingState::Blocked};
  if (contact == nullptr) return std::nullopt;
  return LineStop{contact->u, contact->v, BearingState::Occupied};
}

LineOnMask Localization::lineOf(int line) const {
  return {beam_.columns(line), beam_.values(line), beam_.height()};
}

float Localization::densityOf(int line) const {
  const auto i = static_cast<std::size_t>(line);
  if (histogram_.seen[i] == 0) return 0.0F;
  return static_cast<float>(histogram_.obstacle[i]) / static_cast<float>(histogram_.seen[i]);
}

void Localization::collectCandidates(const FloorOfView& floor, Obstacles& obstacles) const {
  for (const TriangleContact& c : finder_.contacts()) {
    const auto p = floor.at(c.u, c.v);
    if (!p || p->norm() > obstacles.max_range) continue;
    Contact contact;
    contact.bearing = c.line;
    contact.u = static_cast<float>(c.u);
    contact.v = static_cast<float>(c.v);
    contact.p_base = p->cast<float>();
    contact.score = static_cast<float>(c.score);
    obstacles.candidates.push_back(contact);
  }
}

void Localization::selectContacts(Obstacles& obstacles) {
  // Candidates stand line by line, top to bottom: the last of a line is its nearest.
  nearest_.clear();
  for (std::size_t i = 0; i < obstacles.candidates.size(); ++i) {
    const bool last = i + 1 == obstacles.candidates.size() ||
                      obstacles.candidates[i + 1].bearing != obstacles.candidates[i].bearing;
    if (last) nearest_.push_back(static_cast<int>(i));
  }
  if (parameters_.selection == Selection::EveryBearing) {
    // A contact behind a blob without one is not what stops the bearing.
    for (const int i : nearest_) {
      const Contact& contact = obstacles.candidates[static_cast<std::size_t>(i)];
      const Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(contact.bearing)];
      if (bearing.state == BearingState::Occupied) obstacles.contacts.push_back(contact);
    }
    return;
  }
  selection_.clear();
  for (const int i : nearest_) {
    const Contact& c = obstacles.candidates[static_cast<std::size_t>(i)];
    selection_.push_back({c.bearing, c.p_base.norm()});
  }
  ipm_mapping::selectContacts(peaks_, selection_, parameters_.bearing_tolerance, chosen_);
  for (const int k : chosen_) {
    const int i = nearest_[static_cast<std::size_t>(k)];
    obstacles.contacts.push_back(obstacles.candidates[static_cast<std::size_t>(i)]);
  }
}

FrameStatus Localization::process(const GroundView& view, GrayView obstacle_mask,
                                  Obstacles& obstacles) {
  obstacles.bearings.clear();
  obstacles.contacts.clear();
  obstacles.candidates.clear();
  obstacles.view = view;
  obstacles.max_range = effectiveMaxRange(parameters_.max_range, view.camera, view.T_base_camera);

  const VanishingPoints points = vanishingPoints(view);  // eq. 5.5
  obstacles.focus =
      parameters_.mean_pixel_focus ? meanPixelFocus(points) : midFootFocus(points);  // eq. 6.9
  if (!beam_.aim(obstacles.focus, obstacle_mask.width, obstacle_mask.height, parameters_.n_lines,
                 parameters_.beam))
    return FrameStatus::FocusUnusable;

  const auto n_lines = static_cast<std::size_t>(beam_.lines());
  obstacles.bearings.reserve(n_lines);
  obstacles.contacts.reserve(n_lines);
  peaks_.reserve(n_lines);
  nearest_.reserve(n_lines);
  chosen_.reserve(n_lines);
  selection_.reserve(n_lines);

  beam_.sample(obstacle_mask);
  histogram_.count(beam_);                                  // §5.2
  finder_.find(beam_, obstacle_mask, parameters_, lines_);  // §5.3
  obstacles.candidates.reserve(finder_.most());
  findPeaks(histogram_.obstacle, parameters_.single_bin_peaks, peaks_);  // §3.7
  groupPeaks(histogram_.obstacle, parameters_.free_space_rule, parameters_.valley_threshold,
             peaks_);
  const FloorOfView floor(view);
  for (int line = 0; line < beam_.lines(); ++line)
    obstacles.bearings.push_back(floorBearing(lineOf(line), floor, obstacles.max_range,
                                              parameters_.min_floor_share, densityOf(line),
                                              stopOf(line)));
  collectCandidates(floor, obstacles);  // eq. 5.18
  selectContacts(obstacles);            // §5.4.1
  return FrameStatus::Used;
}

}  // namespace ipm_mapping
