/// Exceptions of the package vrda.
#pragma once

namespace vrda::python {

/// An interrupted command, reported as KeyboardInterrupt.
struct Interrupted {};

/// Translates InputError and errors of the file system to vrda.InputError, InternalError to
/// vrda.InternalError.
void register_errors();

}  // namespace vrda::python
