#include "ipm_mapping/detectors/word_length_study.hpp"

#include <algorithm>
#include <set>
#include <sstream>
#include <utility>

#include "ipm_mapping/detectors/floor_bearing.hpp"
#include "ipm_mapping/detectors/localization.hpp"

namespace ipm_mapping {
namespace {

MapParameters markingMap(MapParameters parameters) {
  parameters.update = MapUpdate::MarkOnce;
  return parameters;
}

double medianOf(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The points as a detector would hand them to the map.
Obstacles answerOf(const fpga::SelectedContacts& points, const GroundView& view, bool undistorted,
                   double max_range) {
  Obstacles answer;
  answer.view = view;
  const FloorOfView floor(view);
  for (const std::uint32_t word : points) {
    double u = fpga::wordColumn(word), v = fpga::wordRow(word);
    if (!undistorted) view.camera.undistortPixel(u, v, u, v);
    const auto p = floor.projection.floor({u, v});
    if (!p || p->norm() > max_range) continue;
    Contact contact;
    contact.p_base = p->cast<float>();
    answer.contacts.push_back(contact);
  }
  return answer;
}

std::set<std::pair<int, int>> occupiedCells(const OccupancyMap& map) {
  std::set<std::pair<int, int>> cells;
  const MapGeometry& g = map.geometry();
  for (int y = 0; y < g.height; ++y)
    for (int x = 0; x < g.width; ++x)
      if (map.occupancy(static_cast<std::size_t>(y * g.width + x)) == 100)
        cells.emplace(g.first.x + x, g.first.y + y);
  return cells;
}

int onOneSide(const std::set<std::pair<int, int>>& a, const std::set<std::pair<int, int>>& b) {
  std::vector<std::pair<int, int>> cells;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(cells));
  return static_cast<int>(cells.size());
}

WordLengthRow rowOf(int fraction_bits, const std::vector<fpga::WordLengthResult>& results) {
  WordLengthRow row;
  row.fraction_bits = fraction_bits;
  std::vector<double> medians, contacts;
  for (const fpga::WordLengthResult& r : results) {
    if (!r.usable) continue;
    ++row.pairs;
    medians.push_back(r.median_error);
    row.worst_error = std::max(row.worst_error, r.worst_error);
    row.changed_mask += r.changed_mask;
    row.points += r.points;
    row.lost_points += r.lost_points;
    if (r.lost_points < r.ideal.size) contacts.push_back(r.contact_error);
  }
  if (row.pairs > 0) row.changed_mask /= row.pairs;
  row.median_error = medianOf(medians);
  row.contact_error = medianOf(contacts);
  return row;
}

}  // namespace

WordLengthStudy::WordLengthStudy(const Parameters& parameters, fpga::ExploredWire wire, int first,
                                 int last)
    : parameters_(parameters), wire_(wire), ideal_map_(markingMap(parameters.map)) {
  for (int bits = first; bits <= last; ++bits)
    widths_.push_back({bits, {}, OccupancyMap(markingMap(parameters.map))});
}

std::vector<fpga::WordLengthResult> WordLengthStudy::add(const fpga::ExplorerInput& pair) {
  if (widths_.empty()) return {};
  const auto results = fpga::sweepWordLength(
      pair, parameters_.fpga, wire_, widths_.front().fraction_bits, widths_.back().fraction_bits);
  if (results.empty()) return results;
  const double max_range = effectiveMaxRange(parameters_.localization.max_range, pair.view.camera,
                                             pair.view.T_base_camera);
  const auto answer = [&](const fpga::SelectedContacts& points) {
    return answerOf(points, pair.view, parameters_.fpga.undistort_current, max_range);
  };
  ideal_map_.update(answer(results.front().ideal));
  for (std::size_t i = 0; i < widths_.size(); ++i) {
    widths_[i].results.push_back(results[i]);
    widths_[i].map.update(answer(results[i].selected));
  }
  return results;
}

std::vector<WordLengthRow> WordLengthStudy::rows() const {
  const auto ideal = occupiedCells(ideal_map_);
  std::vector<WordLengthRow> rows;
  for (const Width& width : widths_) {
    WordLengthRow& row = rows.emplace_back(rowOf(width.fraction_bits, width.results));
    row.map_cells = static_cast<int>(ideal.size());
    row.changed_cells = onOneSide(ideal, occupiedCells(width.map));
  }
  return rows;
}

std::string wordLengthCsv(fpga::ExploredWire wire, const std::vector<WordLengthRow>& rows) {
  std::ostringstream out;
  out << "wire,fraction_bits,pairs,median_error_px,worst_error_px,changed_mask,contact_error_px,"
         "points,lost_points,map_cells,changed_cells\n";
  for (const WordLengthRow& r : rows) {
    out << fpga::explored_wire_names[static_cast<std::size_t>(wire)] << ',' << r.fraction_bits
        << ',' << r.pairs << ',' << r.median_error << ',' << r.worst_error << ',' << r.changed_mask
        << ',' << r.contact_error << ',' << r.points << ',' << r.lost_points << ',' << r.map_cells
        << ',' << r.changed_cells << '\n';
  }
  return out.str();
}

}  // namespace ipm_mapping
