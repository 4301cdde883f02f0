#pragma once

#include <array>
#include <optional>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/bearing_selection.hpp"
#include "ipm_mapping/sweep/contact_edge.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"
#include "ipm_mapping/sweep/floor_cost.hpp"
#include "ipm_mapping/sweep/foot_chain.hpp"
#include "ipm_mapping/sweep/free_floor.hpp"
#include "ipm_mapping/sweep/held_contact.hpp"
#include "ipm_mapping/sweep/leaning_surface.hpp"
#include "ipm_mapping/sweep/lens_shading.hpp"
#include "ipm_mapping/sweep/level_top.hpp"
#include "ipm_mapping/sweep/lone_contact.hpp"
#include "ipm_mapping/sweep/motion_refinement.hpp"
#include "ipm_mapping/sweep/moving_obstacle.hpp"
#include "ipm_mapping/sweep/noise_model.hpp"
#include "ipm_mapping/sweep/plain_edge.hpp"
#include "ipm_mapping/sweep/reference_ring.hpp"
#include "ipm_mapping/sweep/remembered_foot.hpp"
#include "ipm_mapping/sweep/rolling_shutter.hpp"
#include "ipm_mapping/sweep/self_calibration.hpp"
#include "ipm_mapping/sweep/specular_cost.hpp"
#include "ipm_mapping/sweep/straight_foot.hpp"
#include "ipm_mapping/sweep/sway.hpp"
#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// The package's own detector: for every beam, does this column look like floor, or like something
/// vertical that stands on the floor at this distance?
class SweepDetector : public Detector {
 public:
  explicit SweepDetector(const SweepParameters& parameters = {},
                         const CalibrationParameters& calibration = {});
  SweepDetector(const SweepDetector&) = delete;  // its parts know one another
  SweepDetector& operator=(const SweepDetector&) = delete;

  void setCamera(const CameraModel& camera, const CameraPose& T_base_camera) override;
  /// Keeps what was learnt about the camera, applied or not, and what stands below the view.
  bool adopt(const Detector& before) override;
  void reset() override;
  FrameStatus process(const Frame& frame, Obstacles& obstacles) override;
  [[nodiscard]] const std::vector<StageTime>& stageTimes() const override { return times_; }
  [[nodiscard]] const char* id() const override { return "sweep"; }
  [[nodiscard]] double timeOffset() const override { return time_offset_; }
  [[nodiscard]] std::optional<CalibrationReport> calibration() const override;

  /// Motion from each reference to the last used frame as the floor shows it.
  [[nodiscard]] int referenceCount() const { return reference_count_; }
  [[nodiscard]] const RefinedMotion& refinedMotion(int reference = 0) const {
    return motions_[static_cast<std::size_t>(reference)];
  }
  /// The last processed frame may become a reference of later ones.
  [[nodiscard]] Kept keptAsReference() const { return kept_; }
  /// Rolling shutter that is undone, seconds from the first row to the last.
  [[nodiscard]] double readout() const { return readout_; }
  /// By which share grey levels in the image's corners are brightened to make up for the lens.
  [[nodiscard]] double lensShading() const { return rectification_.shading(); }
  [[nodiscard]] const PolarGrid& grid() const { return grid_; }
  /// Scores of the last processed frame, candidates x beams.
  [[nodiscard]] ImageView<const float> scores() const { return scores_.score.view(); }
  /// Floor residual against the last reference, sweep rows x lines, 1/32 grey levels.
  [[nodiscard]] ImageView<const std::int16_t> residual() const { return floor_cost_.residual(); }

 private:
  /// One reference of the frame at hand, on the sweep rows.
  struct Planes {
    Image<std::int16_t> even, odd;
    Image<std::uint16_t> floor_cost;
    BeamSums sums;
  };

  /// A reference without its sway, and the rows that it sees: of lines, and common to a beam's.
  struct Steadied {
    Image<std::uint8_t> image;
    std::vector<RowRange> rows, beam_rows;
  };

  void rectifyWith(const CalibrationVector& correction);
  void configure(const CameraPose& T_base_camera);
  void allocate();
  void configureView();
  void rectify(const Frame& frame);
  [[nodiscard]] SE2 footAt(const SE2& T_floor_base) const;
  void learnCalibration();
  void applyReadout();
  void applyTimeOffset();
  void applyShading();
  void shadeWith(double shading);
  void chainAnew();
  void workWith(double readout);
  [[nodiscard]] double longestReadout() const;
  void applyCalibration();
  [[nodiscard]] SE2 expectedMotion(const RectifiedFrame& reference) const;
  bool hasMoved();
  FrameStatus findReferences(bool moved);
  [[nodiscard]] bool floorIsTheSame() const;
  void answer(const Frame& frame, bool new_evidence, Obstacles& obstacles);
  void findContacts(const CurrentView& view);
  void maskFloor();
  void splitCurrent();
  void compareWithReferences(const CurrentView& view);
  bool steady(std::size_t reference);
  void splitReference(const Image<std::uint8_t>& reference, const Photometric& photometric,
                      Planes& planes);
  void fillView(const Frame& frame, Obstacles& obstacles) const;
  void fillObstacles(const CurrentView& current, Obstacles& obstacles);
  void withdrawDoubtful(Obstacles& obstacles) const;
  void holdContacts(const ComparedFrame& frame, bool new_evidence, Obstacles& obstacles);
  void fillCandidates(Obstacles& obstacles) const;
  [[nodiscard]] double heightOf(const BeamChoice& choice) const;
  void doubtLowContacts();
  Contact contactOf(int beam, const BeamChoice& choice) const;
  /// How far the floor of a beam reaches for one reference, and what its near end costs.
  struct FloorReach {
    double range = 0.0;  ///< metres from the camera's foot; 0: not even the near end is floor
    double nearest_cost = 0.0;  ///< sigma^2; 0 where the near end was not seen
  };
  FloorReach floorReach(int beam, const SweepReference& view) const;
  Bearing floorBearing(int beam) const;
  double doubtfulDistance(int beam) const;
  double rangeLimit(double azimuth) const;
  void lap(const char* stage);

  SweepParameters parameters_;
  CalibrationMode calibration_mode_;
  bool learn_readout_;
  double readout_stated_;
  double readout_;  ///< in force, seconds
  bool learn_time_offset_;
  bool learn_shading_;
  double shading_stated_;
  double time_offset_ = 0.0;  ///< that frames should come with, seconds
  SelfCalibration calibration_;
  CameraModel camera_;
  CameraPose T_base_stated_ = CameraPose::Identity();
  CameraPose T_base_camera_ = CameraPose::Identity();  ///< in force
  double max_range_ = 0.0;
  PolarGrid grid_;
  CylindricalRectification rectification_;
  RollingShutter shutter_;
  LensShading shading_;
  NoiseModel noise_;
  MotionRefinement refinement_;
  SwayCorrection sway_;
  FloorCost floor_cost_;
  SpecularCost specular_;
  VerticalSweep sweep_;
  BearingSelection selection_;
  LevelTop level_top_;
  LeaningSurface leaning_;
  ContactEdge edge_;
  StraightFoot straight_foot_;
  FootChain foot_chain_;
  RememberedFoot remembered_foot_;
  LoneContact lone_contact_;
  HeldContact held_contact_;
  PlainEdge plain_edge_;
  FreeFloor free_floor_;
  MovingObstacle moving_;
  ReferenceRing ring_;
  BlockLattice lattice_;

  RectifiedFrame current_;
  Image<std::int16_t> current_grey_, current_odd_;
  Image<std::uint16_t> weight_;
  BeamSums current_sums_;
  std::array<Planes, VerticalSweep::max_references> planes_;
  std::array<Steadied, VerticalSweep::max_references> steady_;
  std::array<const RectifiedFrame*, VerticalSweep::max_references> references_{};
  std::array<SweepReference, VerticalSweep::max_references> views_;
  std::array<RefinedMotion, VerticalSweep::max_references> motions_;
  int reference_count_ = 0;
  SweepScores scores_;
  std::vector<BeamChoice> choices_;
  SE2 last_new_;                             // pose of the last frame that had moved
  double stopped_ = 0.0;                     // its stamp
  double stood_ = 0.0, stood_before_ = 0.0;  // seconds, all in all and until then
  GoingClock going_;
  OdometryOfFrame last_;                          // frame
  SE2 T_floor_last_;                              // of it
  int floor_beams_ = 0, floor_beams_before_ = 0;  // that see floor: now, and when it last drove
  Kept kept_ = Kept::No;
  double chain_offset_ = 0.0;  // of the stamps that floor poses were chained up with
  bool seen_any_ = false, floor_masked_ = false;
  std::vector<StageTime> times_;
  double lap_start_ = 0.0;
};

}  // namespace ipm_mapping::sweep
