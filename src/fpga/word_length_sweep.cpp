// The sweep over one wire's fraction bits.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "ipm_mapping/fpga/word_length.hpp"

namespace ipm_mapping::fpga {
namespace {

double medianOf(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Distances of the sampled points to the exact geometry, where both exist.
std::vector<double> pixelErrors(const GroundView& view, const std::vector<SampledPoint>& sampled) {
  const Eigen::Matrix3d G = view.G();
  const Distortion& d = view.camera.distortion();
  const CameraModel lens(view.camera.intrinsics(), {d.k1, d.k2, 0.0, 0.0, d.k3});
  std::vector<double> errors;
  for (std::size_t i = 0; i < sampled.size(); ++i) {
    const auto width = static_cast<std::size_t>(lens.width());
    const Eigen::Vector3d g =
        G * Eigen::Vector3d(static_cast<double>(i % width), static_cast<double>(i / width), 1.0);
    double u = 0.0, v = 0.0;
    if (!sampled[i].valid || !(g.z() > 0.0)) continue;
    if (!lens.distortPixel(g.x() / g.z(), g.y() / g.z(), u, v)) continue;
    if (u < -0.5 || v < -0.5 || u >= lens.width() - 0.5 || v >= lens.height() - 0.5) continue;
    errors.push_back(std::hypot(sampled[i].u - u, sampled[i].v - v));
  }
  return errors;
}

template <class Pixel>
int changed(const Image<Pixel>& a, const Image<Pixel>& b) {
  int count = 0;
  for (int v = 0; v < a.height(); ++v) {
    for (int u = 0; u < a.width(); ++u) count += a.at(u, v) != b.at(u, v);
  }
  return count;
}

/// Matches each point of long words with the nearest one found.
void comparePoints(const SelectedContacts& ideal, const SelectedContacts& found,
                   WordLengthResult& result) {
  std::vector<double> distances;
  for (const std::uint32_t a : ideal) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::uint32_t b : found) {
      if (std::abs(wordBearing(a) - wordBearing(b)) > 1) continue;
      nearest =
          std::min(nearest, std::hypot(wordColumn(a) - wordColumn(b), wordRow(a) - wordRow(b)));
    }
    if (std::isfinite(nearest)) {
      distances.push_back(nearest);
    } else {
      ++result.lost_points;
    }
  }
  result.points = found.size;
  result.contact_error = medianOf(distances);
}

}  // namespace

std::optional<ExploredWire> exploredWire(const std::string& name) {
  for (std::size_t i = 0; i < explored_wire_count; ++i) {
    if (name == explored_wire_names[i]) return static_cast<ExploredWire>(i);
  }
  return std::nullopt;
}

WordLengths::WordLengths()
    : bits_{formats::HomographyLinear::fraction_bits,
            formats::HomographyOffset::fraction_bits,
            formats::ViewCoordinate::fraction_bits,
            formats::CameraIntrinsic::fraction_bits,
            formats::LensCoefficient::fraction_bits,
            formats::Normalized::fraction_bits,
            0,
            0} {}

WordLengths WordLengths::ideal() {
  WordLengths lengths;
  lengths.bits_ = {22, 18, 16, 20, 24, 24, 8, 12};
  return lengths;
}

WordLengths WordLengths::with(ExploredWire wire, int fraction_bits) const {
  WordLengths copy = *this;
  copy.bits_[static_cast<std::size_t>(wire)] = std::clamp(fraction_bits, 0, longest);
  return copy;
}

std::vector<WordLengthResult> sweepWordLength(const ExplorerInput& input,
                                              const FpgaParameters& parameters, ExploredWire wire,
                                              int first, int last) {
  std::vector<WordLengthResult> results;
  Wires ideal, found;
  WordLengthDatapath long_words(parameters, WordLengths::ideal());
  if (!long_words.run(input, ideal)) return results;
  for (int bits = first; bits <= last; ++bits) {
    WordLengthDatapath datapath(parameters, WordLengths().with(wire, bits));
    WordLengthResult result;
    result.fraction_bits = bits;
    result.ideal = ideal.results.selected;
    result.usable = datapath.run(input, found);
    if (result.usable) {
      std::vector<double> errors = pixelErrors(input.view, datapath.sampled());
      result.worst_error = errors.empty() ? 0.0 : *std::max_element(errors.begin(), errors.end());
      result.median_error = medianOf(errors);
      result.changed_difference = changed(ideal.difference, found.difference);
      result.changed_mask = changed(ideal.mask, found.mask);
      result.threshold_change = found.results.threshold_out - ideal.results.threshold_out;
      result.selected = found.results.selected;
      comparePoints(ideal.results.selected, found.results.selected, result);
    }
    results.push_back(result);
  }
  return results;
}

std::string wordLengthCsv(ExploredWire wire, const std::vector<WordLengthResult>& results) {
  std::ostringstream out;
  out << "wire,fraction_bits,usable,median_error_px,worst_error_px,changed_difference,"
         "changed_mask,threshold_change,points,lost_points,contact_error_px\n";
  for (const WordLengthResult& r : results) {
    out << explored_wire_names[static_cast<std::size_t>(wire)] << ',' << r.fraction_bits << ','
        << r.usable << ',' << r.median_error << ',' << r.worst_error << ',' << r.changed_difference
        << ',' << r.changed_mask << ',' << r.threshold_change << ',' << r.points << ','
        << r.lost_points << ',' << r.contact_error << '\n';
  }
  return out.str();
}

}  // namespace ipm_mapping::fpga
