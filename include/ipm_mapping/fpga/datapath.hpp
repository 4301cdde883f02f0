#pragma once
// One frame through the whole second architecture (the source, figure 6.3): from two raw frames
// and the registers to the points that the FIFO hands to software.

#include <memory>

#include "ipm_mapping/fpga/contact_points.hpp"
#include "ipm_mapping/fpga/frame_parameters.hpp"
#include "ipm_mapping/fpga/free_space.hpp"
#include "ipm_mapping/fpga/otsu.hpp"
#include "ipm_mapping/fpga/overflow.hpp"
#include "ipm_mapping/fpga/selection.hpp"

namespace ipm_mapping::fpga {

struct FastKernels;

/// Everything a frame leaves in registers and arrays (rule 13: cleared at frame start).
struct Results {
  GreyHistogram histogram{};
  std::uint8_t threshold_out = ThresholdRegister::reset_value;
  PolarHistogram bear{};
  Contacts cor{};
  Peaks peaks;
  SelectedContacts selected;
  OverflowCounters overflow;

  bool operator==(const Results& o) const;
};

/// The pixel streams of a frame, written where a view of the frame's size is given. Who leaves a
/// view empty does not get that wire, and the fast engine does not make it.
struct WireImages {
  ImageView<TaggedPixel> difference;
  ImageView<TaggedPixel> gaussian;
  ImageView<std::uint8_t> mask;    ///< 0 or 1
  ImageView<std::uint8_t> eroded;  ///< 0 or 1
};

/// Staged: one typed twin after the other, the readable form. Fast: the same bits, fused.
enum class Engine : std::uint8_t { Staged, Fast };

/// Owns the workspace: after the first frame of a size, run() does not allocate.
class Datapath {
 public:
  explicit Datapath(Engine engine = Engine::Fast);
  /// Fast kernels of a chosen instruction set (fast_kernels.hpp); the default takes the best.
  Datapath(Engine engine, const FastKernels& kernels);
  ~Datapath();
  Datapath(Datapath&&) noexcept;
  Datapath& operator=(Datapath&&) noexcept;

  /// False when the inputs are not runnable(); the results are then those of an empty frame whose
  /// threshold register is left alone.
  bool run(const FrameInputs& inputs, const WireImages& wanted = {});
  [[nodiscard]] const Results& results() const { return results_; }

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
  Engine engine_;
  Results results_;
};

}  // namespace ipm_mapping::fpga
