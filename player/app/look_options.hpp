/// How things look, on the command line of every mode that draws.
#pragma once

#include "app/look.hpp"

namespace CLI {
class App;
}

namespace vrda {

void add_look(CLI::App& mode, LookOptions& look);

}  // namespace vrda
