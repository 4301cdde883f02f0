// Golden vectors for a hardware test bench: the inputs and every wire of one frame, taken from a
// bag or from files. Exit codes: 0 done, 2 wrong usage, 3 input unreadable or missing.

#include <CLI/CLI.hpp>
#include <iostream>

#include "ipm_mapping/detectors/fpga_detector.hpp"
#include "ipm_mapping/fpga/vectors.hpp"
#include "ipm_mapping/ros/bag_arguments.hpp"
#include "ipm_mapping/ros/offline_run.hpp"

namespace {

using namespace ipm_mapping;

struct Arguments : BagArguments {
  std::string inputs;
  std::string out;
  std::int64_t frame = -1;

  void declareAll(CLI::App& app) {
    app.add_option("bag", options.bag, "recording with images and odometry");
    app.add_option("--frame", frame, "index of the image in the bag, from 0");
    app.add_option("--inputs", inputs,
                   "folder with reference.pgm, current.pgm and params.txt, instead of a bag");
    app.add_option("--out", out, "folder for the vectors (made if missing)")->required();
    declare(app);
  }
  void settleAll() {
    const bool from_bag = !options.bag.empty();
    if (from_bag == !inputs.empty()) throw ParameterError("give either a bag or --inputs DIR");
    if (from_bag && frame < 0) throw ParameterError("--frame N: say which image of the bag");
    settle();
  }
};

void dumpInputs(const Arguments& a) {
  const fpga::OwnedInputs owned = fpga::readInputs(a.inputs);
  fpga::dumpVectors(owned.inputs(), a.out);
}

/// Runs the model over the bag, with its history and its threshold register, up to one frame.
void dumpFrame(const Arguments& a) {
  const BagSource bag(a.options.bag, a.options.topics);
  const RunCamera camera = resolveCamera(bag, a.options);
  printWarning(std::cerr, camera.concern);
  FpgaDetector detector(a.options.parameters);
  OfflineRun run(bag, camera, a.options.parameters, detector);
  if (detector.cameraError()) throw BagError(*detector.cameraError());

  const std::string which = "frame " + std::to_string(a.frame);
  bool reached = false;
  OfflineRun::Observers observers;
  observers.frame = [&](std::uint64_t index, FrameStatus status, GrayView current) {
    if (index != static_cast<std::uint64_t>(a.frame)) return true;
    reached = true;
    if (status != FrameStatus::Used) throw BagError(which + " was skipped: " + name(status));
    fpga::dumpVectors({detector.reference(), current, detector.frameSetup().parameters}, a.out);
    return false;
  };
  run.run(observers);
  if (!reached)
    throw BagError(which + " is not in the bag, or has no pose (" +
                   std::to_string(run.report().images) + " images)");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Writes one frame's inputs and every wire of the FPGA model"};
  Arguments arguments;
  arguments.declareAll(app);
  return runTool(
      app, "dump_vectors", argc, argv, [&] { arguments.settleAll(); },
      [&] { arguments.inputs.empty() ? dumpFrame(arguments) : dumpInputs(arguments); });
}
