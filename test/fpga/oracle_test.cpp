// The twin against an independent second implementation of the contract, wire by wire.
//
// By default a few seconds of frames; IPM_FPGA_ORACLE_PIXELS=N compares frames of every kind until
// N pixels went through, IPM_FPGA_ORACLE_SEED=S starts at another seed.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>

#include "fpga/oracle/generator.hpp"
#include "fpga/oracle/vectors.hpp"
#include "ipm_mapping/fpga/fast_kernels.hpp"
#include "ipm_mapping/fpga/vectors.hpp"

namespace ipm_mapping::fpga {
namespace {

FrameParameters twinParameters(const oracle::Params& params) {
  std::map<std::string, int> values;
  for (const oracle::Entry& entry : oracle::entries()) values[entry.name] = params.*entry.value;
  FrameParameters p;
  FrameParameters::fields(
      p, [&](const char* name, Integer& value, Integer, Integer) { value = values.at(name); });
  return p;
}

/// An image inside a larger buffer, so that a stage that forgets the stride is found out.
template <class Pixel>
struct Padded {
  Padded(int w, int h, int margin)
      : width(w),
        height(h),
        margin_(margin),
        pixels(static_cast<size_t>((w + margin) * h), static_cast<Pixel>(0xa5)) {}
  ImageView<Pixel> view() { return {pixels.data(), width, height, width + margin_}; }
  void load(const std::vector<Pixel>& from) {
    for (size_t i = 0; i < from.size(); ++i) {
      const int index = static_cast<int>(i);
      view().at(index % width, index / width) = from[i];
    }
  }
  std::vector<Pixel> content() {
    std::vector<Pixel> out;
    for (int v = 0; v < height; ++v) out.insert(out.end(), view().row(v), view().row(v) + width);
    return out;
  }
  int width, height, margin_;
  std::vector<Pixel> pixels;
};

void copyResults(const Results& r, oracle::Wires& w) {
  constexpr uint32_t point = 0x7ffff;  // selected.txt holds u and v, not the bearing
  w.histogram.assign(r.histogram.begin(), r.histogram.end());
  w.threshold_out = r.threshold_out;
  w.bear.assign(r.bear.begin(), r.bear.end());
  for (const ContactEntry& entry : r.cor) w.cor.push_back({entry.found ? 1 : 0, entry.word});
  w.peaks.assign(r.peaks.begin(), r.peaks.end());
  for (const uint32_t word : r.selected) w.selected.push_back(word & point);
  w.fifo = w.selected;
  for (size_t i = 0; i < wire_count; ++i) {
    w.overflow[i] = static_cast<int64_t>(r.overflow.counts()[i]);
  }
}

/// Runs the twin on views whose rows are `margin` pixels longer than the image.
bool runTwin(Datapath& datapath, const oracle::Inputs& in, int margin, oracle::Wires& w) {
  w = oracle::Wires{};
  w.width = in.params.width;
  w.height = in.params.height;
  Padded<uint8_t> reference(w.width, w.height, margin), current(w.width, w.height, 2 * margin);
  reference.load(in.reference);
  current.load(in.current);
  Padded<TaggedPixel> difference(w.width, w.height, margin), gaussian(w.width, w.height, margin);
  Padded<uint8_t> mask(w.width, w.height, margin), eroded(w.width, w.height, margin);
  const FrameInputs inputs{reference.view(), current.view(), twinParameters(in.params)};
  if (!datapath.run(inputs, {difference.view(), gaussian.view(), mask.view(), eroded.view()})) {
    return false;
  }
  w.difference = difference.content();
  w.gaussian = gaussian.content();
  w.mask = mask.content();
  w.eroded = eroded.content();
  copyResults(datapath.results(), w);
  return true;
}

/// The twin as an application runs it: no wire but the results.
bool runResultsOnly(Datapath& datapath, const oracle::Inputs& in, oracle::Wires& w) {
  const GrayView reference(in.reference.data(), in.params.width, in.params.height);
  const GrayView current(in.current.data(), in.params.width, in.params.height);
  w.cor.clear();
  w.selected.clear();
  if (!datapath.run({reference, current, twinParameters(in.params)})) return false;
  copyResults(datapath.results(), w);
  return true;
}

struct Tally {
  int64_t pixels = 0, frames = 0, mismatches = 0;
  std::array<int64_t, oracle::CounterCount> counters{};
  std::array<int64_t, oracle::EventCount> events{};

  void add(const oracle::Wires& w) {
    pixels += static_cast<int64_t>(w.difference.size());
    ++frames;
    for (size_t i = 0; i < counters.size(); ++i) counters[i] += w.overflow[i];
    for (size_t i = 0; i < events.size(); ++i) events[i] += w.events[i];
  }
};

/// Every engine and instruction set, kept from frame to frame as a node keeps them: a frame must
/// leave no trace in the next.
class Comparison {
 public:
  Comparison() {
    twins_.emplace("staged", Datapath(Engine::Staged));
    for (const FastKernels* kernels : supportedKernels()) {
      twins_.emplace(kernels->name, Datapath(Engine::Fast, *kernels));
    }
  }

  void frame(uint64_t seed, oracle::Kind kind) {
    const oracle::Inputs in = oracle::randomInputs(seed, kind);
    ASSERT_EQ(oracle::checkRanges(in.params), "") << oracle::kindName(kind) << ", seed " << seed;
    compare(in, static_cast<int>(seed % 3) * 5,
            std::string(oracle::kindName(kind)) + ", seed " + std::to_string(seed));
  }

  void compare(const oracle::Inputs& in, int margin, const std::string& where) {
    const oracle::Wires expected = oracle::run(in);
    const std::string size =
        ", " + std::to_string(in.params.width) + "x" + std::to_string(in.params.height);
    for (auto& [name, datapath] : twins_) {
      check(expected, runTwin(datapath, in, margin, found_), name + " (" + where + size + ")");
      if (name == "staged") continue;
      check(expected, runResultsOnly(datapath, in, found_), name + ", no images (" + where + ")");
    }
    tally.add(expected);
  }

  Tally tally;

 private:
  void check(const oracle::Wires& expected, bool ran, const std::string& where) {
    const std::string mismatch = ran ? oracle::firstMismatch(expected, found_) : "did not run";
    if (mismatch.empty()) return;
    if (++tally.mismatches <= 20) ADD_FAILURE() << where << ": " << mismatch;
  }

  std::map<std::string, Datapath> twins_;
  oracle::Wires found_;
};

int64_t fromEnvironment(const char* name, int64_t otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<int64_t>(std::strtod(text, nullptr));
}

/// These cannot happen within rule 13's image size and are checked to stay 0.
bool cannotSaturate(size_t counter) {
  return counter == oracle::ContactS || counter == oracle::ContactH ||
         counter == oracle::ContactScore || counter == oracle::A1;
}

bool isSmall(int kind) {
  return kind == oracle::Tiny || kind == oracle::Limits || kind == oracle::FewLevels ||
         kind == oracle::Uniform || kind == oracle::Extremes;
}

void report(const Tally& tally) {
  std::cout << "[  oracle  ] " << tally.pixels << " pixels in " << tally.frames
            << " frames, each through the staged twins and " << supportedKernels().size()
            << " kernel sets; mismatches: " << tally.mismatches << "\n";
  for (size_t i = 0; i < oracle::CounterCount; ++i) {
    std::cout << "[  oracle  ] " << oracle::counter_names[i] << " " << tally.counters[i] << "\n";
  }
}

TEST(FpgaOracle, EveryWireAndCounterOfEveryEngineIsEqual) {
  const int64_t goal = fromEnvironment("IPM_FPGA_ORACLE_PIXELS", 24000000);
  const int64_t first = fromEnvironment("IPM_FPGA_ORACLE_SEED", 0);
  Comparison comparison;
  for (int64_t seed = first; comparison.tally.pixels < goal; ++seed) {
    for (int kind = 0; kind < oracle::KindCount; ++kind) {
      // Small images are cheap: several of them for one of the others.
      const uint64_t frames = isSmall(kind) ? 8 : 1;
      for (uint64_t i = 0; i < frames; ++i) {
        comparison.frame(static_cast<uint64_t>(seed) * frames + i, static_cast<oracle::Kind>(kind));
      }
    }
  }
  const Tally& tally = comparison.tally;
  report(tally);
  EXPECT_EQ(tally.mismatches, 0);
  // What never happened has not been compared.
  for (size_t i = 0; i < oracle::CounterCount; ++i) {
    EXPECT_EQ(tally.counters[i] > 0, !cannotSaturate(i)) << oracle::counter_names[i];
  }
  for (size_t i = 0; i < oracle::EventCount; ++i) {
    EXPECT_GT(tally.events[i], 0) << oracle::event_names[i];
  }
}

/// A frame of `kind` small enough to be run often.
oracle::Inputs smallInputs(oracle::Kind kind) {
  for (uint64_t seed = 1;; ++seed) {
    oracle::Inputs in = oracle::randomInputs(seed, kind);
    if (in.current.size() < 16000) return in;
  }
}

/// Sets one parameter anywhere in its range; the images are cut or filled up where it is a size.
void change(oracle::Inputs& in, const oracle::Entry& entry, oracle::Random& random) {
  oracle::Params& p = in.params;
  const bool size = entry.value == &oracle::Params::width || entry.value == &oracle::Params::height;
  p.*entry.value = random.in(entry.lowest, size ? 130 : entry.highest);
  if (p.focus_v == 0) p.focus_v = 1;
  p.memory_rows = std::clamp(p.memory_rows, p.height, 524288 / p.width);
  in.reference.resize(static_cast<size_t>(p.width * p.height), 9);
  in.current.resize(static_cast<size_t>(p.width * p.height), 99);
}

/// What an engine keeps from the last frame (maps, buffers) must not outlive its cause: every
/// parameter is changed alone, and changed back.
TEST(FpgaOracle, EveryParameterTakesEffectAlone) {
  Comparison comparison;
  oracle::Random random(3);
  for (const oracle::Kind kind : {oracle::TurningRadius, oracle::PaperOrder, oracle::Limits}) {
    const oracle::Inputs plain = smallInputs(kind);
    for (const oracle::Entry& entry : oracle::entries()) {
      for (int undistort = 0; undistort <= 1; ++undistort) {
        oracle::Inputs in = plain;
        in.params.undistort_current = undistort;
        const std::string where = std::string(oracle::kindName(kind)) + ", " + entry.name;
        comparison.compare(in, 0, where + " before");
        change(in, entry, random);
        comparison.compare(in, 0, where + " changed");
      }
    }
  }
  EXPECT_EQ(comparison.tally.mismatches, 0);
}

class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_(
            (std::filesystem::temp_directory_path() /
             (name + std::to_string(std::filesystem::hash_value(std::filesystem::current_path())) +
              "_" + std::to_string(static_cast<int64_t>(::getpid()))))
                .string()) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(FpgaOracle, FilesOfDumpVectorsAreEqualByteForByte) {
  for (int kind = 0; kind < oracle::KindCount; ++kind) {
    for (uint64_t seed = 1000; seed < 1002; ++seed) {
      const Folder in_folder("ipm_oracle_in_"), out_folder("ipm_oracle_out_");
      const oracle::Inputs in = oracle::randomInputs(seed, static_cast<oracle::Kind>(kind));
      oracle::writeInputs(in, in_folder.path());
      dumpVectors(readInputs(in_folder.path()).inputs(), out_folder.path());
      EXPECT_EQ(oracle::compareOutputs(oracle::run(in), out_folder.path()), "")
          << oracle::kindName(static_cast<oracle::Kind>(kind)) << ", seed " << seed;
    }
  }
}

TEST(FpgaOracle, InputsWrittenByTheTwinAreReadBackEqual) {
  const Folder in_folder("ipm_oracle_in_"), out_folder("ipm_oracle_out_");
  const oracle::Inputs in = oracle::randomInputs(7, oracle::Uniform);
  oracle::writeInputs(in, in_folder.path());
  dumpVectors(readInputs(in_folder.path()).inputs(), out_folder.path());
  const oracle::Inputs back = oracle::readInputs(out_folder.path());
  EXPECT_EQ(oracle::paramsText(back.params), oracle::paramsText(in.params));
  EXPECT_EQ(back.reference, in.reference);
  EXPECT_EQ(back.current, in.current);
}

/// Empty when the text is accepted, else what the refusal says.
std::string refusal(const std::string& text) {
  try {
    const FrameParameters p = parseParameters(text);
    validate(p);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

oracle::Params with(int oracle::Params::*field, int value) {
  oracle::Params params;
  params.*field = value;
  if (field == &oracle::Params::width || field == &oracle::Params::height) {
    params.memory_rows = 524288 / std::max(1, params.width);
  }
  return params;
}

TEST(FpgaOracle, EveryParameterIsAcceptedToTheEndsOfItsRangeAndRefusedBeyondByName) {
  for (const oracle::Entry& entry : oracle::entries()) {
    const bool rows = std::string(entry.name) == "memory_rows";
    const int lowest = rows ? 480 : entry.lowest, highest = rows ? 819 : entry.highest;
    EXPECT_EQ(refusal(oracle::paramsText(with(entry.value, lowest))), "") << entry.name;
    EXPECT_EQ(refusal(oracle::paramsText(with(entry.value, highest))), "") << entry.name;
    for (const int beyond : {lowest - 1, highest + 1}) {
      const std::string what = refusal(oracle::paramsText(with(entry.value, beyond)));
      EXPECT_NE(what.find(entry.name), std::string::npos) << entry.name << " " << beyond << what;
    }
  }
  EXPECT_NE(refusal(oracle::paramsText(with(&oracle::Params::focus_v, 0))).find("focus_v"),
            std::string::npos);
}

TEST(FpgaOracle, EveryMissingRepeatedOrUnknownNameIsRefusedByName) {
  const std::string all = oracle::paramsText(oracle::Params{});
  ASSERT_EQ(refusal(all), "");
  for (const oracle::Entry& entry : oracle::entries()) {
    const std::string name = entry.name;
    const size_t begin = ("\n" + all).find("\n" + name + " = ");
    const size_t end = all.find('\n', begin) + 1;
    const std::string line = all.substr(begin, end - begin);
    const std::string without = all.substr(0, begin) + all.substr(end);
    EXPECT_NE(refusal(without).find(name), std::string::npos) << name << " missing";
    EXPECT_NE(refusal(all + line).find(name), std::string::npos) << name << " repeated";
    EXPECT_NE(refusal(all + "x_" + line).find("x_" + name), std::string::npos) << "unknown";
  }
}

}  // namespace
}  // namespace ipm_mapping::fpga
