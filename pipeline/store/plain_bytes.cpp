#include "store/plain_bytes.hpp"

#include "store/plain_stream.hpp"
#include "store/registry.hpp"
#include "store/trace_registry.hpp"
#include "store/values.hpp"

namespace vrda {
namespace {

template <typename Visit>
std::string bytes_of(const Visit& visit)
{
  PlainWriter stream;
  // Counted first, so that one allocation suffices.
  stream.count();
  visit(stream);
  stream.reserve_counted();
  visit(stream);
  return stream.take();
}

}  // namespace

std::string plain_bytes(const MotionModel& model)
{
  return bytes_of([&](auto& visitor) { visit_motion_model(model, visitor); });
}

MotionModel motion_model_of(std::string_view bytes, const std::string& file)
{
  MotionModel model;
  visit_motion_model(model, PlainReader(bytes, file));
  if (!model.has_compartments) set_no_compartments(model);
  require_none(check_values(model), file);
  return model;
}

std::string plain_bytes(const Trace& trace)
{
  return bytes_of([&](auto& visitor) { visit_trace(trace, visitor); });
}

Trace trace_of(std::string_view bytes, const std::string& file)
{
  Trace trace;
  visit_trace(trace, PlainReader(bytes, file));
  require_none(check_values(trace), file);
  return trace;
}

}  // namespace vrda
