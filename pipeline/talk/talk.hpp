/// What the program says: data to standard output, talk to standard error.
#pragma once

#include <string>

namespace vrda {

enum class ExitCode : int {
  done = 0,
  bad_input = 2,          ///< usage, job, mesh, file
  too_many_unsolved = 3,  ///< finished, but more attitudes unsolved than the job allows
  interrupted = 4,        ///< resumable
  our_mistake = 5,
};

/// Silences say(); warnings and errors stay.
void be_quiet();

/// One line each; control characters are printed as \x1b.
void say(const std::string& line);
void warn(const std::string& line);

}  // namespace vrda
