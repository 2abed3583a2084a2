#include "analysis/fit_journal.hpp"

#include <filesystem>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/little_endian.hpp"
#include "job/input_file.hpp"
#include "solve/case_solver.hpp"

namespace vrda::analysis {
namespace {

constexpr core::FrameFormat evaluation_format{"VRDAFITJ", 1, std::uint32_t{1} << 28, "evaluation"};
// Must be changed when the same question may give other evaluations.
constexpr const char* fit_version = "identification 2";

void append_numbers(std::string& bytes, const std::vector<double>& numbers)
{
  core::append_i32(bytes, static_cast<std::int32_t>(numbers.size()));
  for (const double number : numbers) core::append_double(bytes, number);
}

std::vector<double> take_numbers(core::ByteReader& reader)
{
  std::vector<double> numbers;
  const std::int32_t n = reader.take_i32();
  for (std::int32_t k = 0; k < n && reader.is_valid(); ++k) numbers.push_back(reader.take_double());
  return numbers;
}

std::optional<Evaluation> evaluation_of(std::string_view bytes)
{
  core::ByteReader reader(bytes);
  Evaluation evaluation;
  evaluation.kind = reader.take_i8();
  evaluation.at = take_numbers(reader);
  evaluation.values = take_numbers(reader);
  if (!reader.is_valid() || reader.n_bytes_left() != 0) return std::nullopt;
  return evaluation;
}

}  // namespace

std::string identification_key(const FitData& data, const IdentifyPlan& plan,
                               const std::vector<std::string>& hashes_of_data)
{
  std::string text = fit_version;
  for (const job::Case* job_case : {data.motion, data.laxity}) {
    if (job_case == nullptr) continue;
    text += '\n' + solve::fingerprint_of(*job_case) + '\n';
    for (const double deg : job_case->grid.flexion_deg) text += shortest_decimal(deg) + ' ';
  }
  for (const Unknown& unknown : plan.unknowns) {
    text += '\n' + unknown.name;
    for (const double number : {unknown.sd, unknown.from, unknown.to}) text += ' ' + shortest_decimal(number);
  }
  for (const double load :
       {data.loads.anterior_force_n, data.loads.internal_moment_nmm, data.loads.varus_moment_nmm})
    text += '\n' + shortest_decimal(load);
  text += '\n' + std::to_string(data.loads.load_steps);
  for (const std::string& hash : hashes_of_data) text += '\n' + hash;
  return job::sha256_of(text);
}

core::FrameWriter open_evaluations(const std::string& path, const std::string& key, bool is_fresh,
                                      std::vector<Evaluation>& known)
{
  std::error_code error;
  if (is_fresh || !std::filesystem::exists(path, error))
    return core::FrameWriter::create(path, key, evaluation_format);
  std::optional<core::FrameWriter> writer = core::FrameWriter::try_lock(path, evaluation_format);
  const auto take = [&](std::string_view frame) -> std::string {
    std::optional<Evaluation> evaluation = evaluation_of(frame);
    if (!evaluation) return "a frame that is not an evaluation";
    known.push_back(std::move(*evaluation));
    return {};
  };
  const core::FrameFileSummary summary =
      core::parse_frames(path, core::read_frame_file(path), evaluation_format, take);
  if (summary.key != key)
    throw InputError(
        {path, "key", "the journal of another job or other measurements", "--fresh, or another --output"});
  if (!writer) core::refuse_locked(path);
  writer->cut(summary.valid_bytes);
  return std::move(*writer);
}

std::string evaluation_bytes(const Evaluation& evaluation)
{
  std::string bytes;
  core::append_i8(bytes, evaluation.kind);
  append_numbers(bytes, evaluation.at);
  append_numbers(bytes, evaluation.values);
  return bytes;
}

}  // namespace vrda::analysis
