/// `vrda bands`: the bands of an uncertain job, as CSV or JSON.
#pragma once

#include <string>

#include "core/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct BandsOptions {
  std::string file;
  std::string table = "bands";  ///< bands, fibres, shares or samples
  bool as_json = false;

  /// Declares the options of the command.
  void add_to(CLI::App& command);
};

/// Throws InputError if the model has no /uncertainty.
core::ExitCode bands_command(const BandsOptions& options);

}  // namespace vrda::app
