#include "store/plain_bytes.hpp"

#include "store/plain_stream.hpp"
#include "store/registry.hpp"
#include "store/trace_registry.hpp"
#include "store/values.hpp"

namespace vrda {
namespace {

/// Bytes of all values: room made at once saves moving what is there already.
class ByteCount : public RegistryVisitor {
 public:
  template <typename Member>
  void operator()(const Dataset&, const Member& member)
  {
    n_bytes += values_of(member).size_bytes();
  }

  std::size_t n_bytes = std::size_t{1} << 20;  ///< with room for texts
};

template <typename Visit>
std::string bytes_of(const Visit& visit)
{
  ByteCount count;
  visit(count);
  PlainWriter stream;
  stream.reserve(count.n_bytes);
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
