// The options of `web`.
#include "app/options.hpp"

#include <CLI/CLI.hpp>

namespace vrda {

CLI::App* add_web(CLI::App& app, WebOptions& options)
{
  CLI::App* web =
      app.add_subcommand("web", "Serve a motion model and a page that shows it to a browser on this machine");
  web->add_option("FILE", options.file, "Motion model (.h5)")->required();
  web->add_option("--port", options.port, "Of 127.0.0.1 (default: a free one)")
      ->type_name("N")
      ->check(CLI::Range(0, 65535));
  web->add_flag("--open", options.is_open, "Open the page in the desktop's browser");
  web->add_flag("--quiet", options.is_quiet, "Only the address");
  web->footer(
      "Prints the page's address and serves until Ctrl-C. The address holds a token: keep it to yourself.\n"
      "Neither other machines are answered nor requests without the token.\n"
      "Example:\n  vrda-player web knee.h5 --open");
  return web;
}

}  // namespace vrda
