#include "python/errors.hpp"

#include <pybind11/pybind11.h>

#include <filesystem>

#include "core/files.hpp"
#include "core/text.hpp"

namespace py = pybind11;

namespace vrda::python {
namespace {

/// Raises vrda.InputError with the facts as attributes.
void raise_input_error(const InputError& error)
{
  const py::object type = py::module_::import("vrda._errors").attr("InputError");
  const InputError::Facts& f = error.facts();
  const py::object raised = type(error.what(), f.file, f.field, f.found, f.wanted, f.line);
  PyErr_SetObject(type.ptr(), raised.ptr());
}

}  // namespace

void register_errors()
{
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      raise_input_error(error);
    } catch (const std::filesystem::filesystem_error& error) {
      raise_input_error(input_error_of(error));
    } catch (const InternalError& error) {
      const py::object type = py::module_::import("vrda._errors").attr("InternalError");
      PyErr_SetString(type.ptr(), error.what());
    } catch (const Interrupted&) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
    }
  });
}

}  // namespace vrda::python
