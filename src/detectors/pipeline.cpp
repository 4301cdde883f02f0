#include "ipm_mapping/detectors/pipeline.hpp"

#include "ipm_mapping/detectors/chain_detector.hpp"
#include "ipm_mapping/detectors/fpga_detector.hpp"
#include "ipm_mapping/sweep/sweep_detector.hpp"

namespace ipm_mapping {

std::unique_ptr<Detector> makeDetector(const Parameters& parameters) {
  parameters.validate();
  switch (parameters.detector.kind) {
    case DetectorKind::Sweep:
      return std::make_unique<sweep::SweepDetector>(parameters.sweep, parameters.calibration);
    case DetectorKind::Chain:
    case DetectorKind::FirstArchitecture:
      return std::make_unique<ChainDetector>(parameters);
    case DetectorKind::Fpga:
      return std::make_unique<FpgaDetector>(parameters);
  }
  return nullptr;
}

}  // namespace ipm_mapping
