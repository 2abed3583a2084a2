/// The two exception types. The commands catch them (pipeline: app, run; player: app, loop); the
/// few other handlers are listed in scripts/check_includes (CATCHES), each with its reason.
#pragma once

#include <stdexcept>
#include <string>

namespace vrda::inline core {

/// An error that the user can fix. what() is "file: line 3, field: found ..., wanted ...": one printable
/// line; control characters are escaped.
class InputError : public std::runtime_error {
 public:
  struct Facts {
    std::string file;    ///< file, or the command line's option
    std::string field;   ///< key, line or part of the file; may be empty
    std::string found;   ///< the value found
    std::string wanted;  ///< the value required
    int line = 0;        ///< line number in the file; 0: unknown
  };

  explicit InputError(Facts facts);
  const Facts& facts() const { return facts_; }

 private:
  Facts facts_;
};

/// A violated internal invariant: a defect of the program.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws InternalError with `why` unless the condition holds; active in release builds too.
void check(bool condition, const char* why);

}  // namespace vrda::inline core
