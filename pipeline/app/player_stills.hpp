/// Pictures for a report, made by vrda-player in a process of its own: the pipeline draws nothing.
#pragma once

#include <string>

#include "report/report.hpp"

namespace vrda {

/// `player` as given, which must then be there (InputError), or the vrda-player beside the running program;
/// empty when there is none.
std::string player_program(const std::string& player);

/// Stills of the motion model `file` at several flexions from its front and side. What goes wrong is told in
/// the note; the report goes on without pictures.
Stills player_stills(const std::string& player, const std::string& file, const MotionModel& model);

}  // namespace vrda
