#include "ipm_mapping/sweep/sweep_detector.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr double rest = 0.25;  // seconds without motion after which a robot stands

}  // namespace

void SweepDetector::reset() {
  ring_.clear();
  refinement_.forgetFloor();
  floor_masked_ = false;
  calibration_.reset();
  free_floor_.reset();
  remembered_foot_.reset();
  lone_contact_.reset();
  held_contact_.reset();
  moving_.reset();
  seen_any_ = false;
  going_.reset();
}

void SweepDetector::rectify(const Frame& frame) {
  current_.velocity = frame.velocity;
  const bool undo = shutter_.matters(frame.velocity, readout_);
  current_.readout = undo ? readout_ : 0.0;
  current_.sheared = undo && !shutter_.reaches(frame.velocity, readout_);
  if (undo)
    shutter_.rectify(rectification_, frame.image, frame.velocity, readout_, current_.image.view());
  else
    rectification_.rectify(frame.image, shutter_.rows(), current_.image.view());
}

void SweepDetector::lap(const char* stage) {
  const double t = now();
  times_.push_back({stage, t - lap_start_});
  lap_start_ = t;
}

/// Pose of the camera's foot, which looks where the robot looks.
SE2 SweepDetector::footAt(const SE2& T_floor_base) const {
  return T_floor_base *
         SE2{T_base_camera_.translation().x(), T_base_camera_.translation().y(), 0.0};
}

FrameStatus SweepDetector::process(const Frame& frame, Obstacles& obstacles) {
  obstacles.clear();
  times_.clear();
  if (camera_.width() == 0) return FrameStatus::NoCamera;
  if (frame.image.width != camera_.width() || frame.image.height != camera_.height())
    return FrameStatus::SizeMismatch;
  if (grid_.lines == 0 || sweep_.beams() == 0) return FrameStatus::GeometryUnusable;
  lap_start_ = now();
  rectify(frame);
  current_.mean.evaluate(lattice_, current_.image.view());
  current_.T_odom_base = frame.T_odom_base;
  current_.stamp = frame.stamp;
  current_.time_offset = frame.time_offset;
  current_.went = going_.add(current_, frame.stamp);
  const bool moved = hasMoved();
  current_.T_floor_base = T_floor_last_ * odometryBetween(last_, current_);
  if (moved && current_.time_offset != chain_offset_) chainAnew();
  lap("rectification");
  const SE2 T_floor_base = current_.T_floor_base;
  FrameStatus status = findReferences(moved);
  const bool used = status == FrameStatus::Used;
  if (used || status == FrameStatus::Watched) {
    answer(frame, used, obstacles);
    if (used) {
      floor_beams_before_ = floor_beams_;
    } else if (!floorIsTheSame()) {
      obstacles.clear();
      current_.T_floor_base = T_floor_base;
      status = FrameStatus::NoMotion;
    }
  }
  last_ = static_cast<const OdometryOfFrame&>(current_);
  T_floor_last_ = current_.T_floor_base;
  learnCalibration();
  kept_ = ring_.offer(current_);
  if (kept_ != Kept::No && !obstacles.bearings.empty())
    moving_.remember(footAt(T_floor_last_), obstacles);
  applyCalibration();
  applyReadout();
  applyTimeOffset();
  applyShading();
  return status;
}

/// Compares the frame at hand with its references; `new_evidence` where the robot has moved.
void SweepDetector::answer(const Frame& frame, bool new_evidence, Obstacles& obstacles) {
  fillView(frame, obstacles);
  splitCurrent();
  const CurrentView view{current_grey_.view(), weight_.view(), &noise_.sweepRows(),
                         current_sums_.view()};
  const bool first_look = !floor_masked_;
  findContacts(view);
  if (first_look) findContacts(view);  // the motion was found on what may not have been floor
  const ComparedFrame compared{view, views_.data(), reference_count_, sweep_};
  straight_foot_.complete(compared, choices_);
  const SE2 T_floor_foot = footAt(current_.T_floor_base);
  lone_contact_.mark(T_floor_foot, new_evidence, choices_);
  doubtLowContacts();
  foot_chain_.complete(compared, choices_);
  remembered_foot_.complete(compared, T_floor_foot, frame.stamp - stood_, new_evidence, choices_);
  doubtLowContacts();  // of those as well
  moving_.complete(compared, T_floor_foot, frame.stamp, choices_);
  lap("known_feet");
  fillObstacles(view, obstacles);
  holdContacts(compared, new_evidence, obstacles);
  lap("answer");
}

/// While a robot stands nearly all of the floor it saw stays in view. Where that is gone it has
/// been pushed, and its wheels do not say so, or the light has changed.
bool SweepDetector::floorIsTheSame() const {
  constexpr int least_beams = 8;  // fewer say nothing
  constexpr double least_share = 0.25;
  if (!motions_[0].photometric.withinBounds()) return false;
  return floor_beams_before_ < least_beams || floor_beams_ >= least_share * floor_beams_before_;
}

/// The sweep's own contacts. They mask the floor for the next motion; guesses must not.
void SweepDetector::findContacts(const CurrentView& view) {
  compareWithReferences(view);
  const SelectionParameters& p = parameters_.selection;
  sweep_.evaluate(view, views_.data(), reference_count_,
                  static_cast<float>(p.weak_share * p.publish_score), scores_);
  level_top_.add({view, views_.data(), reference_count_, sweep_}, selection_,
                 calibration_.remainingTilt(), scores_);
  lap("vertical_sweep");
  selection_.select(scores_, choices_);
  leaning_.refine(view, views_.data(), reference_count_, sweep_, scores_, choices_);
  edge_.refine(view, sweep_, scores_, choices_);
  maskFloor();
  lap("bearing_selection");
}

/// Whether the current frame may show something new. While the robot stands its references grow no
/// older, for as long as it is to look on.
bool SweepDetector::hasMoved() {
  const SE2& pose = current_.T_odom_base;
  const SweepReferenceParameters& p = parameters_.reference;
  const bool moved =
      !seen_any_ || std::hypot(pose.x - last_new_.x, pose.y - last_new_.y) >= p.min_motion;
  if (moved) {
    last_new_ = pose;
    stopped_ = current_.stamp;
    stood_before_ = stood_;
  } else {
    stood_ = stood_before_ + std::clamp(current_.stamp - stopped_ - rest, 0.0, p.watch);
  }
  seen_any_ = true;
  current_.stood = stood_;
  return moved;
}

/// One or two earlier frames far enough back; says why there is none.
FrameStatus SweepDetector::findReferences(bool moved) {
  const SweepReferenceParameters& p = parameters_.reference;
  reference_count_ = 0;
  const double rested = current_.stamp - stopped_ - rest;
  if (!moved && !(rested >= 0.0 && rested < p.watch)) return FrameStatus::NoMotion;
  const double height = grid_.height, longer = p.long_baseline * height;
  const auto take = [&](double baseline) {
    const RectifiedFrame* found = ring_.find(current_, baseline);
    if (found == nullptr || (reference_count_ > 0 && found == references_[0])) return false;
    references_[static_cast<std::size_t>(reference_count_++)] = found;
    return true;
  };
  take(p.short_baseline * height);
  // what the history does not reach back to is better than nothing
  if (p.long_baseline > 0.0 && !take(std::max(longer, p.least_long_baseline))) take(longer);
  if (reference_count_ > 0) return moved ? FrameStatus::Used : FrameStatus::Watched;
  if (!moved) return FrameStatus::NoMotion;
  return ring_.farEnough(current_, p.short_baseline * grid_.height) ? FrameStatus::TooMuchRotation
                                                                    : FrameStatus::NoReference;
}

/// What the next frame may take for floor: everything in front of this frame's contacts.
void SweepDetector::maskFloor() {
  refinement_.forgetFloor();
  for (int line = 0; line < grid_.lines; ++line) {
    const int beam = std::clamp((line - kernels::beam_lines / 2) / parameters_.evidence.beam_step,
                                0, sweep_.beams() - 1);
    double nearest = 0.0;
    for (int b = std::max(0, beam - 1); b <= std::min(sweep_.beams() - 1, beam + 1); ++b) {
      const BeamChoice& choice = choices_[static_cast<std::size_t>(b)];
      if (choice.any())
        nearest =
            std::max(nearest, sweep_.sweepRow(choice.candidate) * PolarGrid::rows_per_sweep_row);
    }
    if (nearest > 0.0)
      refinement_.setFloorBegin(line, static_cast<int>(nearest + 0.03 * grid_.rows_per_log));
  }
  floor_masked_ = true;
}

void SweepDetector::splitCurrent() {
  for (int line = 0; line < grid_.lines; ++line)
    kernels::splitRows(current_.image.row(line), Photometric{}.fixedGain(), 0, grid_.sweepRows(),
                       current_grey_.row(line), current_odd_.row(line));
  current_sums_.evaluate(current_grey_.view());
  noise_.evaluate(current_grey_.view(), current_odd_.view(), weight_.view());
  lap("noise_model");
}

/// Makes the reference as the robot would have seen it with the attitude it has now; false where it
/// is that already.
bool SweepDetector::steady(std::size_t reference) {
  const Sway& sway = motions_[reference].sway;
  if (sway.size() <= parameters_.refinement.least_sway) return false;
  Steadied& steady = steady_[reference];
  sway_.remove(sway, references_[reference]->image, steady.image, steady.rows);
  commonRows(steady.rows, kernels::beam_lines + 1, steady.beam_rows);
  return true;
}

void SweepDetector::splitReference(const Image<std::uint8_t>& reference,
                                   const Photometric& photometric, Planes& planes) {
  for (int line = 0; line < grid_.lines; ++line)
    kernels::splitRows(reference.row(line), photometric.fixedGain(), photometric.fixedOffset(),
                       grid_.sweepRows(), planes.even.row(line), planes.odd.row(line));
  planes.sums.evaluate(planes.even.view());
}

void SweepDetector::compareWithReferences(const CurrentView& view) {
  const Eigen::Vector2d foot = T_base_camera_.translation().head<2>();
  const bool drives = current_.stamp == stopped_;  // else it is the same evidence again
  for (std::size_t q = 0; q < static_cast<std::size_t>(reference_count_); ++q) {
    const RectifiedFrame& reference = *references_[q];
    motions_[q] = refinement_.refine(current_, reference, expectedMotion(reference),
                                     reference.T_floor_base.inverse() * current_.T_floor_base);
    motions_[q].reference_stamp = reference.stamp;
    if (learn_shading_ && drives && motions_[q].refined)
      shading_.learn(rectification_, refinement_.floor(motions_[q]));
  }
  current_.T_floor_base = references_[0]->T_floor_base * motions_[0].motion;
  lap("motion_refinement");
  for (std::size_t q = 0; q < static_cast<std::size_t>(reference_count_); ++q) {
    Planes& planes = planes_[q];
    const bool swayed = steady(q);
    const Image<std::uint8_t>& reference = swayed ? steady_[q].image : references_[q]->image;
    const FootMotion motion(motions_[q].motion, foot);
    floor_cost_.evaluate(view, reference.view(), motion, motions_[q].photometric,
                         planes.floor_cost.view(), swayed ? &steady_[q].rows : nullptr);
    splitReference(reference, motions_[q].photometric, planes);
    views_[q] = {planes.even.view(),
                 planes.odd.view(),
                 planes.floor_cost.view(),
                 motion,
                 swayed ? &steady_[q].beam_rows : nullptr,
                 planes.sums.view(),
                 references_[q]->stamp};
    if (parameters_.evidence.specular_prior < 9.0)
      specular_.apply(view, sweep_, views_[q], motions_[q].motion.theta, planes.floor_cost.view());
  }
  lap("floor_cost");
}

}  // namespace ipm_mapping::sweep
