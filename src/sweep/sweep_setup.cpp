// What the detector is made of: compiled anew for every camera, pose and readout time.
#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int expected_stages = 10;

}  // namespace

SweepDetector::SweepDetector(const SweepParameters& parameters,
                             const CalibrationParameters& calibration)
    : parameters_(parameters),
      calibration_mode_(calibration.mode),
      learn_readout_(calibration.learn_readout && calibration.mode != CalibrationMode::Off),
      readout_stated_(calibration.readout_time),
      readout_(calibration.readout_time),
      learn_time_offset_(calibration.learn_time_offset && calibration.mode != CalibrationMode::Off),
      learn_shading_(calibration.learn_shading && calibration.mode != CalibrationMode::Off),
      shading_stated_(calibration.lens_shading),
      calibration_(calibration, parameters.refinement) {
  shading_.configure(calibration);
  rectification_.setShading(shading_stated_);
  times_.reserve(expected_stages);
}

void SweepDetector::setCamera(const CameraModel& camera, const CameraPose& T_base_camera) {
  if (!(camera == camera_)) {
    calibration_.forgetCamera();
    readout_ = readout_stated_;
    time_offset_ = 0.0;
    shading_.forget();
    rectification_.setShading(shading_stated_);
  }
  camera_ = camera;
  T_base_stated_ = T_base_camera;
  calibration_.setCamera(T_base_camera);
  rectifyWith(CalibrationVector::Zero());
  reset();
}

/// Everything that depends on the pose that frames are rectified with.
void SweepDetector::configure(const CameraPose& T_base_camera) {
  T_base_camera_ = T_base_camera;
  max_range_ = effectiveMaxRange(camera_, T_base_camera, parameters_.grid.max_range);
  grid_ = makePolarGrid(camera_, T_base_camera, parameters_.grid, max_range_);
  rectification_.configure(camera_, T_base_camera, grid_);
  ring_.configure(grid_, parameters_.reference);
  configureView();
  allocate();
  selection_.configure(sweep_, grid_.height, parameters_.selection);
  level_top_.configure(sweep_, parameters_.selection);
  leaning_.configure(parameters_.selection);
  free_floor_.configure(parameters_.free_floor);
  edge_.configure(parameters_.selection);
  straight_foot_.configure(sweep_, parameters_.free_floor, parameters_.foot);
  foot_chain_.configure(sweep_, parameters_.free_floor, parameters_.foot);
  remembered_foot_.configure(sweep_, parameters_.free_floor, parameters_.foot);
  lone_contact_.configure(sweep_, parameters_.selection);
  held_contact_.configure(sweep_, parameters_.foot);
  plain_edge_.configure(sweep_, parameters_.free_floor, parameters_.foot);
  moving_.configure(sweep_, max_range_, parameters_.evidence, parameters_.selection,
                    parameters_.moving);
}

/// Everything that depends on how much of the view can be worked with.
void SweepDetector::configureView() {
  const Eigen::Vector2d foot = T_base_camera_.translation().head<2>();
  shutter_.configure(rectification_, foot, longestReadout());
  const std::vector<RowRange>& rows = shutter_.rows();
  noise_.configure(grid_, rows, parameters_.noise);
  lattice_.configure(grid_, rows);
  refinement_.configure(grid_, rows, foot, parameters_.refinement);
  shading_.reserve(refinement_.mostSamples());
  floor_masked_ = false;
  sway_.configure(grid_, rows);
  specular_.configure(grid_, rows, parameters_.evidence);
  floor_cost_.configure(grid_, rows, parameters_.evidence);
  sweep_.configure(grid_, rows, noise_.sweepRows(), parameters_.grid.max_support,
                   parameters_.evidence);
}

void SweepDetector::allocate() {
  current_.image.resize(grid_.rows, grid_.lines);
  current_grey_.resize(grid_.sweepRows(), grid_.lines);
  current_odd_.resize(grid_.sweepRows(), grid_.lines);
  weight_.resize(grid_.sweepRows(), grid_.lines);
  current_sums_.configure(grid_.sweepRows(), grid_.lines, parameters_.evidence.beam_step);
  for (Planes& planes : planes_) {
    planes.even.resize(grid_.sweepRows(), grid_.lines);
    planes.odd.resize(grid_.sweepRows(), grid_.lines);
    planes.floor_cost.resize(grid_.sweepRows(), sweep_.beams());
    planes.sums.configure(grid_.sweepRows(), grid_.lines);
  }
  for (Steadied& steady : steady_) {
    steady.image.resize(grid_.rows, grid_.lines);
    steady.rows.reserve(static_cast<std::size_t>(grid_.lines));
    steady.beam_rows.reserve(static_cast<std::size_t>(grid_.lines));
  }
  choices_.reserve(static_cast<std::size_t>(grid_.lines));
}

}  // namespace ipm_mapping::sweep
