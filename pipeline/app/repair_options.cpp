// The options of `vrda repair`.
#include <CLI/CLI.hpp>

#include "app/repair_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void add_repair_options(CLI::App& c, RepairCommandOptions& o)
{
  constexpr double largest = 1e6;
  c.add_option("file", o.file, "Motion model (HDF5), a sequence of frames")->required();
  c.add_option("-o,--output", o.output, "Motion model to write")->required();
  c.add_option("--noise-mm", o.noise_mm,
               "Standard deviation of the measured position of the rotation centre: one number, or X,Y,Z; 0: "
               "exact")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(number(0.0, largest));
  c.add_option("--noise-deg", o.noise_deg,
               "Standard deviation of the measured rotation: one number, or about X,Y,Z; 0: exact")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(number(0.0, largest));
  c.add_option("--smooth", o.smooth,
               "Period in frames whose amplitude smoothing halves; auto: from the noise; none")
      ->check(number(2.0, largest, {"auto", "none"}))
      ->capture_default_str();
  c.add_option("--gap-mm", o.gap_mm,
               "Largest gap along Delta, of each compartment if there are any; auto: median of the measured "
               "gaps plus twice their spread without noise; none")
      ->check(number(0.0, largest, {"auto", "none"}))
      ->capture_default_str();
  c.add_flag("--replace", o.may_replace, "Replace an existing output");
  add_threads(c, o.n_threads);
  c.add_flag("--json", o.as_json, "Print JSON");
}

}  // namespace vrda::app
