/// The mode `follow` on the command line.
#pragma once

#include "app/follow.hpp"

namespace CLI {
class App;
}

namespace vrda {

CLI::App* add_follow(CLI::App& app, FollowOptions& options);

}  // namespace vrda
