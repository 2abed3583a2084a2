/// The two kinds of exceptions (STYLE.md 4). The commands catch them (pipeline: app, run; player: app, loop);
/// the few other places stand in scripts/check_includes (CATCHES), each with its reason. The rest answers
/// with facts.
#pragma once

#include <stdexcept>
#include <string>

namespace vrda {

/// Somebody outside can fix it. what() reads "file: line 3, field: found ..., wanted ...": one printable
/// line, whatever bytes the facts quote.
class InputError : public std::runtime_error {
 public:
  struct Facts {
    std::string file;    ///< file, or the command line's option
    std::string field;   ///< key, line or part of the file; may be empty
    std::string found;   ///< what stands there
    std::string wanted;  ///< what would have been right
    int line = 0;        ///< of the file, where the field is in one; 0: none
  };

  explicit InputError(Facts facts);
  const Facts& facts() const { return facts_; }

 private:
  Facts facts_;
};

/// We broke a promise to ourselves.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws InternalError with `why` unless the condition holds; active in release builds too.
void check(bool condition, const char* why);

}  // namespace vrda
