#pragma once

#include <optional>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/detectors/floor_bearing.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/stages/contact_points.hpp"
#include "ipm_mapping/stages/free_space.hpp"
#include "ipm_mapping/stages/polar_histogram.hpp"
#include "ipm_mapping/stages/selection.hpp"

namespace ipm_mapping {

/// Third link of a chain: obstacle mask in, obstacles out.
class Locator {
 public:
  virtual ~Locator() = default;
  /// mask: W x H of the view's camera. Fills everything of `obstacles` but `frame`, `separability`
  /// and `threshold`.
  virtual FrameStatus process(const GroundView& view, GrayView obstacle_mask,
                              Obstacles& obstacles) = 0;
};

/// Third link of the chain: polar histogram, contact points, free space, selection (the source,
/// §5.2-5.4, §6.8-6.10).
class Localization : public Locator {
 public:
  explicit Localization(const LocalizationParameters& parameters = {}) : parameters_(parameters) {}

  FrameStatus process(const GroundView& view, GrayView obstacle_mask,
                      Obstacles& obstacles) override;
  void setParameters(const LocalizationParameters& parameters) { parameters_ = parameters; }

  /// The beam of the last process(): for pictures.
  [[nodiscard]] const PolarBeam& beam() const { return beam_; }
  [[nodiscard]] const PolarHistogram& histogram() const { return histogram_; }
  [[nodiscard]] const std::vector<Peak>& peaks() const { return peaks_; }

 private:
  [[nodiscard]] std::optional<LineStop> stopOf(int line) const;
  [[nodiscard]] LineOnMask lineOf(int line) const;
  [[nodiscard]] float densityOf(int line) const;
  void collectCandidates(const FloorOfView& floor, Obstacles& obstacles) const;
  void selectContacts(Obstacles& obstacles);

  LocalizationParameters parameters_;
  PolarBeam beam_;
  PolarHistogram histogram_;
  ContactFinder finder_;
  std::vector<LineContacts> lines_;
  std::vector<Peak> peaks_;
  std::vector<int> nearest_, chosen_;
  std::vector<SelectionCandidate> selection_;
};

/// Range that is looked at, metres from the base origin: the parameter, or 2 m, or three times the
/// distance at which the floor comes into view where that is more.
[[nodiscard]] double effectiveMaxRange(double parameter, const CameraModel& camera,
                                       const CameraPose& T_base_camera);

}  // namespace ipm_mapping
