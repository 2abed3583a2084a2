#include "store/read_separately.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <new>
#include <utility>

#include "core/error.hpp"
#include "store/binary_stream.hpp"
#include "store/confinement.hpp"
#include "store/motion_model_file.hpp"
#include "store/parse_hdf5.hpp"
#include "store/seal.hpp"
#include "store/serialize_models.hpp"
#include "store/trace_file.hpp"

namespace vrda::store {
namespace {

/// First code of the child process's answer.
enum class Kind : std::int8_t { value, input_error, internal_error };

std::function<void(const std::string&)>& unconfined_listener()
{
  static std::function<void(const std::string&)> listener;
  return listener;
}

/// In the separate process: the result of `parse` for the file's content, or the error. Throws nothing.
template <typename Parse>
std::string parse_answer(const std::string& path, const Parse& parse)
{
  std::string why_unconfined;
  const auto answer = [&](Kind kind, const std::vector<std::string>& texts) {
    BinaryWriter stream;
    stream.write_value(why_unconfined);
    stream.write_value(static_cast<std::int8_t>(kind));
    for (const std::string& text : texts) stream.write_value(text);
    return stream.take();
  };
  const auto refusal = [&](const InputError::Facts& facts) {
    return answer(Kind::input_error, {facts.file, facts.field, facts.found, facts.wanted});
  };
  try {
    const Hdf5Content content = read_hdf5(path);
    why_unconfined = confine_this_process();
    const std::string value = parse(content);
    return answer(Kind::value, {}) + value;
  } catch (const InputError& error) {
    return refusal(error.facts());
  } catch (const std::bad_alloc&) {
    return refusal({path, "", "a file that needs more memory than the limit", intact_file});
  } catch (const std::exception& error) {
    return answer(Kind::internal_error, {error.what()});
  }
}

/// The serialized values of an answer; throws the error if the answer contains one.
std::string_view value_of(const std::string& answer, const std::string& path)
{
  BinaryReader stream(answer, path);
  std::string why_unconfined;
  stream.read_value(why_unconfined);
  if (!why_unconfined.empty() && unconfined_listener())
    std::exchange(unconfined_listener(), {})(why_unconfined);
  std::int8_t kind = 0;
  stream.read_value(kind);
  if (kind == static_cast<std::int8_t>(Kind::value))
    return std::string_view(answer).substr(answer.size() - stream.left());
  InputError::Facts facts;
  if (kind == static_cast<std::int8_t>(Kind::input_error)) {
    for (std::string* text : {&facts.file, &facts.field, &facts.found, &facts.wanted})
      stream.read_value(*text);
    throw InputError(facts);
  }
  std::string why;
  stream.read_value(why);
  throw InternalError(why);
}

std::string text_of_complete(const ProcessResult& answer, const std::string& path)
{
  if (answer.is_complete) return answer.text;
  throw InputError(
      {path, "", "a file that HDF5 cannot read (its process ended with " + answer.text + ")", intact_file});
}

template <typename Parse>
std::string read_in_process(const std::string& path, const Parse& parse)
{
  const auto work = [&] { return parse_answer(path, parse); };
  return text_of_complete(run_separately(work, path, reading_limits(path)), path);
}

}  // namespace

ProcessLimits reading_limits(const std::string& path)
{
  struct stat status = {};
  const std::uint64_t size =
      stat(path.c_str(), &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
  ProcessLimits limits;
  limits.memory_bytes = std::max(limits.memory_bytes, 8 * size);
  limits.result_bytes = std::max(limits.result_bytes, 4 * size);
  return limits;
}

void on_unconfined_read(std::function<void(const std::string&)> report)
{
  unconfined_listener() = std::move(report);
}

SeparateModelRead::SeparateModelRead(const std::string& path) : SeparateModelRead(path, reading_limits(path))
{
}

SeparateModelRead::SeparateModelRead(const std::string& path, const ProcessLimits& limits)
    : path_(path),
      work_(
          [&path] {
            return parse_answer(
                path, [](const Hdf5Content& content) { return serialize(parse_motion_model(content)); });
          },
          path, limits)
{
}

MotionModel SeparateModelRead::model()
{
  const std::string answer = text_of_complete(work_.wait_for_result(), path_);
  return deserialize_motion_model(value_of(answer, path_), path_);
}

MotionModel read_motion_model(const std::string& path)
{
  return SeparateModelRead(path).model();
}

Trace read_trace(const std::string& path)
{
  const std::string answer =
      read_in_process(path, [](const Hdf5Content& content) { return serialize(parse_trace(content)); });
  return trace_of(value_of(answer, path), path);
}

std::vector<Finding> validate_hdf5(const std::string& path)
{
  const std::string answer = read_in_process(path, [](const Hdf5Content& content) {
    BinaryWriter stream;
    for (const Finding& finding : findings_in(content))
      for (const std::string* text : {&finding.where, &finding.found, &finding.wanted})
        stream.write_value(*text);
    return stream.take();
  });
  BinaryReader stream(value_of(answer, path), path);
  std::vector<Finding> findings;
  while (stream.left() > 0) {
    Finding& finding = findings.emplace_back();
    for (std::string* text : {&finding.where, &finding.found, &finding.wanted}) stream.read_value(*text);
  }
  return findings;
}

}  // namespace vrda::store
