/// The mode `web` on the command line.
#pragma once

#include "web/server.hpp"

namespace CLI {
class App;
}

namespace vrda {

CLI::App* add_web(CLI::App& app, WebOptions& options);

}  // namespace vrda
