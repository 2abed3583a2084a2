#include "store/read_apart.hpp"

#include <new>

#include "core/error.hpp"
#include "store/motion_model_file.hpp"
#include "store/plain_bytes.hpp"
#include "store/plain_stream.hpp"
#include "store/separate_process.hpp"
#include "store/trace_file.hpp"

namespace vrda {
namespace {

constexpr const char* an_intact_file = "an intact motion model or trace (HDF5)";

/// What an answer begins with.
enum class Kind : std::int8_t { value, input_error, internal_error };

std::string answer_of(Kind kind, const std::vector<std::string>& texts)
{
  PlainWriter stream;
  stream.pass(static_cast<std::int8_t>(kind));
  for (const std::string& text : texts) stream.pass(text);
  return stream.take();
}

std::string answer_of(const InputError::Facts& facts)
{
  return answer_of(Kind::input_error, {facts.file, facts.field, facts.found, facts.wanted});
}

/// The plain bytes that `read` gives, or what went wrong. Throws nothing.
template <typename Read>
std::string answered(const std::string& path, const Read& read)
{
  try {
    return answer_of(Kind::value, {}) + read();
  } catch (const InputError& error) {
    return answer_of(error.facts());
  } catch (const std::bad_alloc&) {
    return answer_of({path, "", "more than memory is allowed to hold", an_intact_file});
  } catch (const std::exception& error) {
    return answer_of(Kind::internal_error, {error.what()});
  }
}

/// The plain bytes in an answer; throws what stands there instead.
std::string_view value_of(const std::string& answer, const std::string& path)
{
  PlainReader stream(answer, path);
  std::int8_t kind = 0;
  stream.pass(kind);
  if (kind == static_cast<std::int8_t>(Kind::value)) return std::string_view(answer).substr(1);
  InputError::Facts facts;
  if (kind == static_cast<std::int8_t>(Kind::input_error)) {
    for (std::string* text : {&facts.file, &facts.field, &facts.found, &facts.wanted}) stream.pass(*text);
    throw InputError(facts);
  }
  std::string why;
  stream.pass(why);
  throw InternalError(why);
}

std::string whole(const SeparateAnswer& answer, const std::string& path)
{
  if (answer.is_whole) return answer.text;
  throw InputError(
      {path, "", "a file that HDF5 cannot read (it ended with " + answer.text + ")", an_intact_file});
}

}  // namespace

ModelReading::ModelReading(const std::string& path, const ProcessLimits& limits)
    : path_(path),
      work_([&path] { return answered(path, [&] { return plain_bytes(read_motion_model(path)); }); }, path,
            limits)
{
}

MotionModel ModelReading::model()
{
  const std::string answer = whole(work_.answer(), path_);
  return motion_model_of(value_of(answer, path_), path_);
}

MotionModel read_motion_model_apart(const std::string& path, const ProcessLimits& limits)
{
  return ModelReading(path, limits).model();
}

Trace read_trace_apart(const std::string& path, const ProcessLimits& limits)
{
  const auto read = [&] { return answered(path, [&] { return plain_bytes(read_trace(path)); }); };
  const std::string answer = whole(answer_apart(read, path, limits), path);
  return trace_of(value_of(answer, path), path);
}

}  // namespace vrda
