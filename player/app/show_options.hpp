/// The mode `show` on the command line.
#pragma once

#include "app/show.hpp"

namespace CLI {
class App;
}

namespace vrda {

CLI::App* add_show(CLI::App& app, ShowOptions& options);

}  // namespace vrda
