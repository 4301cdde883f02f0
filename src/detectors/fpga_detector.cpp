#include "ipm_mapping/detectors/fpga_detector.hpp"

#include <algorithm>
#include <limits>

#include "ipm_mapping/detectors/floor_bearing.hpp"
#include "ipm_mapping/detectors/localization.hpp"
#include "ipm_mapping/detectors/reference_status.hpp"
#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "ipm_mapping/stopwatch.hpp"

namespace ipm_mapping {
namespace {

FrameStatus statusOf(fpga::SetupStatus status) {
  switch (status) {
    case fpga::SetupStatus::Ok:
      return FrameStatus::Used;
    case fpga::SetupStatus::HomographyUnusable:
      return FrameStatus::GeometryUnusable;
    case fpga::SetupStatus::FocusUnusable:
      return FrameStatus::FocusUnusable;
  }
  return FrameStatus::GeometryUnusable;
}

}  // namespace

FpgaDetector::FpgaDetector(const Parameters& parameters)
    : parameters_(parameters), references_(parameters.reference), software_(parameters.fpga) {}

void FpgaDetector::setCamera(const CameraModel& camera, const CameraPose& T_base_camera) {
  camera_ = camera;
  T_base_camera_ = T_base_camera;
  camera_error_ = software_.setCamera(camera);
  has_camera_ = !camera_error_;
  gaussian_.ensure(camera.width(), camera.height());
  eroded_.ensure(camera.width(), camera.height());
  mask_.ensure(camera.width(), camera.height());
  columns_.resize(static_cast<std::size_t>(camera.height()));
  values_.resize(columns_.size());
  reset();
}

void FpgaDetector::reset() {
  references_.clear();
  reference_ = nullptr;
  threshold_.reset();  // rule 9
}

GrayView FpgaDetector::reference() const {
  return reference_ == nullptr ? GrayView{} : reference_->image.view();
}

FrameStatus FpgaDetector::prepare(const Frame& frame, Obstacles& obstacles) {
  reference_ = nullptr;
  if (camera_error_) return FrameStatus::CameraUnsupported;
  if (!has_camera_) return FrameStatus::NoCamera;
  if (frame.image.width != camera_.width() || frame.image.height != camera_.height())
    return FrameStatus::SizeMismatch;
  const ReferenceSelector::Choice choice = references_.choose(frame.stamp, frame.T_odom_base);
  if (choice.verdict != ReferenceVerdict::Chosen) return frameStatus(choice.verdict);
  reference_ = choice.reference;
  obstacles.view = {frame.stamp,    reference_->stamp, camera_,
                    T_base_camera_, frame.T_odom_base, choice.motion};
  setup_ = software_.setup(obstacles.view, threshold_.value());
  return statusOf(setup_.status);
}

void FpgaDetector::run(const Frame& frame) {
  fpga::WireImages wanted;
  wanted.gaussian = gaussian_.view();
  wanted.eroded = eroded_.view();
  has_difference_ = keep_difference_;
  if (keep_difference_) {
    difference_.ensure(camera_.width(), camera_.height());
    wanted.difference = difference_.view();
  }
  datapath_.run({reference_->image.view(), frame.image, setup_.parameters}, wanted);
  threshold_.load(datapath_.results().threshold_out);
}

void FpgaDetector::composeMask() {
  for (int v = 0; v < mask_.height(); ++v) {
    const std::uint8_t* eroded = eroded_.row(v);
    const fpga::TaggedPixel* gaussian = gaussian_.row(v);
    std::uint8_t* out = mask_.row(v);
    for (int u = 0; u < mask_.width(); ++u)
      out[u] =
          static_cast<std::uint8_t>(eroded[u]                                      ? mask::obstacle
                                    : (gaussian[u] & fpga::no_correspondence) != 0 ? mask::unseen
                                                                                   : mask::floor);
  }
}

void FpgaDetector::layLine(int line) {
  std::fill(columns_.begin(), columns_.end(), PolarBeam::outside);
  const fpga::FocusWord word{static_cast<int>(setup_.parameters.focus_u),
                             static_cast<int>(setup_.parameters.focus_v)};
  fpga::OverflowCounters ignored;
  fpga::BeamLine beam(line, word, ignored);
  const int rows = fpga::beamRows(word, camera_.height());
  for (int v = 0; v < rows; ++v, beam.step(ignored)) {
    if (beam.column() < 0 || beam.column() >= camera_.width()) continue;
    const auto row = static_cast<std::size_t>(v);
    columns_[row] = static_cast<std::int16_t>(beam.column());
    values_[row] = mask_.at(beam.column(), v);
  }
}

Contact FpgaDetector::contactOf(std::uint32_t word, const GroundProjection& floor) const {
  Contact contact;
  contact.bearing = fpga::wordBearing(word);
  double u = fpga::wordColumn(word), v = fpga::wordRow(word);
  // The source streams the current frame raw: its contacts are raw pixels (rule 6).
  if (!parameters_.fpga.undistort_current) camera_.undistortPixel(u, v, u, v);
  contact.u = static_cast<float>(u);
  contact.v = static_cast<float>(v);
  const auto p = floor.floor({u, v});
  contact.p_base = p ? Eigen::Vector2f(p->cast<float>())
                     : Eigen::Vector2f::Constant(std::numeric_limits<float>::infinity());
  return contact;
}

void FpgaDetector::describe(Obstacles& obstacles) {
  const fpga::Results& results = datapath_.results();
  const FloorOfView floor(obstacles.view);
  const LocalizationParameters& p = parameters_.localization;
  composeMask();
  for (int line = 0; line < fpga::line_count; ++line) {
    layLine(line);
    const LineOnMask on_mask{columns_.data(), values_.data(), camera_.height()};
    const auto i = static_cast<std::size_t>(line);
    std::optional<LineStop> stop;
    if (results.cor[i].found) {
      const std::uint32_t word = results.cor[i].word;
      stop = LineStop{fpga::wordColumn(word), fpga::wordRow(word), BearingState::Occupied};
    } else if (const int row = lowestRun(on_mask, p.min_occupied_pixels); row >= 0) {
      stop = LineStop{columns_[static_cast<std::size_t>(row)], row, BearingState::Blocked};
    }
    const float density =
        static_cast<float>(results.bear[i]) / static_cast<float>(camera_.height());
    obstacles.bearings.push_back(
        floorBearing(on_mask, floor, obstacles.max_range, p.min_floor_share, density, stop));
  }
  const auto keep = [&](std::uint32_t word, std::vector<Contact>& list) {
    const Contact contact = contactOf(word, floor.projection);
    if (contact.p_base.norm() <= static_cast<float>(obstacles.max_range)) list.push_back(contact);
  };
  for (const fpga::ContactEntry& entry : results.cor)
    if (entry.found) keep(entry.word, obstacles.candidates);
  for (const std::uint32_t word : results.selected) keep(word, obstacles.contacts);
}

FrameStatus FpgaDetector::process(const Frame& frame, Obstacles& obstacles) {
  Stopwatch watch(times_);
  obstacles.clear();
  obstacles.frame = frame.index;
  const FrameStatus status = prepare(frame, obstacles);
  watch.lap("software_part");
  if (status == FrameStatus::Used) {
    obstacles.max_range =
        effectiveMaxRange(parameters_.localization.max_range, camera_, T_base_camera_);
    obstacles.focus = setup_.focus;
    run(frame);
    obstacles.threshold =
        static_cast<int>(std::max(setup_.parameters.threshold_in, setup_.parameters.min_threshold));
    watch.lap("datapath");
    describe(obstacles);
    watch.lap("points");
  }
  if (!frame.image.empty() && status != FrameStatus::SizeMismatch)
    references_.remember(frame.stamp, frame.T_odom_base, frame.image);
  watch.lap("remember");
  return status;
}

}  // namespace ipm_mapping
