#pragma once
// The datapath fused into one sweep over the rows: the bits of the staged twins, kept in cache.

#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/fpga/datapath.hpp"
#include "ipm_mapping/fpga/fast_kernels.hpp"

namespace ipm_mapping::fpga {

/// The fixed map of rule 4 applied to the generator's own grid, made once per camera: what the
/// current stream is undistorted with (rule 6), and the first half of paper_order.
class LensMap {
 public:
  /// Makes the map when camera or size differ from the last call's.
  void prepare(const FrameParameters& p, std::ptrdiff_t stride, const FastKernels& kernels);

  /// Row v of the undistorted stream; pixels without correspondence are left undefined.
  void fetch(const GrayView& frame, int v, std::uint8_t* out) const;
  [[nodiscard]] const std::uint8_t* valid(int v) const { return valid_.row(v); }
  /// 12.6 coordinates after distortion, invalid where they do not fit.
  void coordinates(int v, CoordinateRow& row) const;
  [[nodiscard]] const LensCounts& counts() const { return counts_; }

 private:
  /// Neighbours in the output that are neighbours in the frame.
  struct Run {
    std::int32_t source;
    std::int16_t target, length;
  };
  void makeRow(const FrameParameters& p, std::ptrdiff_t stride, int v, const FastKernels& kernels);
  void appendRuns(const std::int32_t* offsets, const std::uint8_t* valid, int width);

  FrameParameters key_;
  std::ptrdiff_t stride_ = -1;
  Image<std::uint8_t> valid_;
  Image<std::int32_t> x_, y_;
  std::vector<Run> runs_;
  std::vector<std::size_t> first_run_;
  LensCounts counts_;
  CoordinateRow row_;
};

/// Histogram of 8-bit rows, counted in pairs of neighbours: half the updates, and equal pixels
/// seldom wait for each other.
class RowHistogram {
 public:
  void clear();
  void add(const std::uint8_t* row, int width);
  /// Bins of the pixels that are not invalid_grey.
  void collect(GreyHistogram& bins) const;

 private:
  std::array<std::uint32_t, 65536> pairs_;
  GreyHistogram singles_;
};

class FastEngine {
 public:
  explicit FastEngine(const FastKernels& kernels) : kernels_(&kernels) {}

  /// Rows and columns that the fused sweep needs; smaller frames are left to the staged twins.
  static constexpr int smallest_side = 3;

  /// Everything up to Cor. The inputs are runnable() and the results are cleared.
  void run(const FrameInputs& inputs, const WireImages& wanted, Results& results);

 private:
  void start(const FrameInputs& inputs, const WireImages& wanted, Results& results);
  void startBeam();
  void warpRow(int v);
  void differenceRow(int v);
  void gaussianRow(int v);
  void maskRow(int v, const std::uint8_t* gaussian);
  void erodedRow(int v, const BitRow& bits);
  void erode(int v);
  void finishBeam();

  const FastKernels* kernels_;
  const FrameInputs* inputs_ = nullptr;
  const WireImages* wanted_ = nullptr;
  Results* results_ = nullptr;
  int width_ = 0, height_ = 0, beam_rows_ = 0, threshold_ = 0;

  LensMap lens_map_;
  LensConstants lens_{};
  LensCounts lens_counts_;
  MachineConstants machine_{};
  RowHistogram histogram_;
  CoordinateRow coordinates_;
  LineRegisters lines_;
  std::array<BitRow, 3> masks_;
  BitRow eroded_;
  alignas(64) std::int32_t offsets_[row_capacity];
  alignas(64) std::uint8_t current_[row_capacity];
  alignas(64) std::uint8_t all_valid_[row_capacity];
  alignas(64) std::uint8_t difference_[3][row_capacity];
  alignas(64) std::uint8_t valid_[3][row_capacity];
  alignas(64) std::uint8_t gaussian_[row_capacity];
};

/// Constants of rule 4 from the registers.
[[nodiscard]] LensConstants lensConstants(const FrameParameters& p);

}  // namespace ipm_mapping::fpga
