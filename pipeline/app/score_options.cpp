// The options of `vrda score`.
#include <CLI/CLI.hpp>

#include "app/score_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void ScoreCommandOptions::add_to(CLI::App& command)
{
  command.add_option("model", model, "Motion model (HDF5), or a table of a motion")->required();
  command.add_option("--against", against, "Measured motion: a table, or a motion model (HDF5)")->required();
  command.add_option("--set", set, "Motion of a model: raw, two_sided, degree_N, ...")->capture_default_str();
  command
      .add_option("--match", match,
                  "Match frames by flexion or by key; default: flexion for a grid, else key")
      ->check(one_of({"flexion", "key"}));
  command
      .add_option(
          "--align", align,
          "Fitted before scoring: none, constant (an offset of each coordinate) or rigid (a transform "
          "of each body's frame)")
      ->check(one_of({"none", "constant", "rigid"}))
      ->capture_default_str();
  command.add_option("--rows", rows,
                     "Rows of the measurement to score: A:B (from 1, both included), first-half or "
                     "second-half; default: all");
  command.add_option("--fit-rows", fit_rows,
                     "Rows that fit the alignment and the baselines, like --rows; default: those scored");
  command
      .add_option("--line", line,
                  "The straight line of the baseline is over flexion or key; default: as the frames match")
      ->check(one_of({"flexion", "key"}));
  command
      .add_option("--translations", translations,
                  "rotation-centre (Grood-Suntay axes) or mesh-origin (of the moving meshes, along the "
                  "reference's axes)")
      ->check(one_of({"rotation-centre", "mesh-origin"}))
      ->capture_default_str();
  command.add_option("--centre", centre_mm, "X,Y,Z: rotation centre, canonical mm; default: the model's")
      ->delimiter(',')
      ->expected(3)
      ->check(any_number());
  command.add_option(
      "--long-axis", long_axis,
      "push (the model's Delta) or X,Y,Z: coordinates about axes turned so that this direction "
      "is the long axis; default: the joint's own axes");
  command.add_option("--side", side, "Side of two tables: right (default) or left; a model states its side")
      ->check(one_of({"right", "left"}));
  command
      .add_option("--angles", angles,
                  "Unit of the angles of a table: deg or rad; default: as it states, else deg")
      ->check(one_of({"deg", "rad"}));
  command
      .add_option("--column", columns,
                  "COORDINATE=COLUMN of a table, as of vrda import: flexion=-knee_angle_r has the opposite "
                  "sign; may be repeated")
      ->allow_extra_args(false)
      ->take_all();
  command.add_flag("--bridge", bridges,
                   "Score frames across unsolved flexions too, on the line between the "
                   "nearest solved ones");
  command.add_flag("--json", as_json, "Print JSON");
}

}  // namespace vrda::app
