#include "bench/bench_setup.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "documents/document.hpp"
#include "store/motion_model_file.hpp"
#include "store/scaled_model.hpp"
#include "store/solved_cells.hpp"
#include "view/arguments.hpp"

namespace vrda {
namespace {

constexpr const char* bench_words = "a bench file (schemas/bench.md)";

/// Length and last bytes, which hold the checksum of everything before: what tells one model's file from
/// another.
std::string seal_of_file(const std::string& path)
{
  constexpr std::streamoff seal_bytes = 16;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff n = file ? static_cast<std::streamoff>(file.tellg()) : 0;
  std::string last(static_cast<std::size_t>(std::min(n, seal_bytes)), '\0');
  file.seekg(n - static_cast<std::streamoff>(last.size()));
  file.read(last.data(), static_cast<std::streamsize>(last.size()));
  if (!file) throw InputError({path, "", "no file that can be read", "a motion model"});
  std::string text = std::to_string(n) + " ";
  for (const char c : last) {
    constexpr const char* digits = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    text += {digits[byte >> 4], digits[byte & 15]};
  }
  return text;
}

/// A bench that is shown waits for no probe and no marker: what is told of the tracker is of the bodies.
void leave_out_calibration_tools(BenchFile& bench)
{
  if (!bench.tracker) return;
  // They stand behind those of the last role.
  bench.tracker->tools.resize(first_tool_of(bench, static_cast<BodyRole>(n_body_roles)));
}

struct Texts {
  std::string bench_path, bench, calibration_path, calibration;
};

BenchSetup made_setup(const Texts& texts, const std::string& model_path, const std::string& set)
{
  BenchFile bench = parsed_bench_file(texts.bench, texts.bench_path);
  leave_out_calibration_tools(bench);
  Calibration calibration = texts.calibration.empty()
                                ? nominal_calibration(bench)
                                : parsed_calibration(texts.calibration, texts.calibration_path, bench);
  MotionModel model = scaled_model(read_motion_model(model_path), calibration.subject_scale);
  const std::string chosen = chosen_set(model, model_path, set);
  Motion motion(model, chosen);
  const SolverFrame frame = solver_frame(model, 0);
  RecordingFacts facts{
      texts.bench_path,         texts.bench, texts.calibration_path, texts.calibration, model_path,
      seal_of_file(model_path), chosen};
  return {std::move(model), std::move(motion),      frame,
          std::move(bench), std::move(calibration), std::move(facts)};
}

}  // namespace

BenchSetup read_bench_setup(const BenchOptions& options)
{
  if (options.bench.empty())
    throw InputError({"--bench", "", "nothing", std::string(bench_words) + ", or --replay"});
  Texts texts;
  texts.bench_path = options.bench;
  texts.bench = document_text(options.bench, bench_words);
  texts.calibration_path = options.calibration;
  // One that is still to be written begins with the nominal values.
  if (!options.calibration.empty() && std::filesystem::exists(options.calibration))
    texts.calibration = document_text(options.calibration, "a calibration file (schemas/calibration.md)");
  return made_setup(texts, options.file, options.set);
}

BenchSetup setup_of(const Recording& recording, const BenchOptions& options)
{
  const RecordingFacts& facts = recording.facts;
  if (!options.bench.empty() || !options.calibration.empty()) {
    throw InputError({options.bench.empty() ? "--calibration" : "--bench", "", "a file beside --replay",
                      "none: the recording has its own"});
  }
  if (const std::string seal = seal_of_file(options.file); seal != facts.model_seal) {
    throw InputError({options.file, "", "another motion model (" + seal + ")",
                      "that of the recording, " + facts.model_path + " (" + facts.model_seal + ")"});
  }
  const std::string set = options.set.empty() ? facts.set : options.set;
  return made_setup({facts.bench_path, facts.bench_text, facts.calibration_path, facts.calibration_text},
                    options.file, set);
}

}  // namespace vrda
