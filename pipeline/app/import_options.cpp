// The options of `vrda import`.
#include <CLI/CLI.hpp>

#include "app/import_command.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void add_import_options(CLI::App& c, ImportOptions& o)
{
  const auto add_term = [&](const char* name, std::string& word, std::vector<std::string> words,
                            const char* what) {
    words.emplace_back("auto");
    c.add_option(name, word, what)->check(one_of(words));
  };
  const auto add_repeated = [&](const char* name, std::vector<std::string>& texts, const char* what) {
    c.add_option(name, texts, what)->allow_extra_args(false)->take_all();
  };
  c.add_option("job", o.job_file, "Job file (TOML): meshes, frames, side, Delta; its grid is not used")
      ->required();
  c.add_option("--motion", o.motion, "Table with one pose per frame: .csv, .sto, .mot or .tra")->required();
  c.add_option("-o,--output", o.output, "Motion model; default: results/<job name>/<job name>.h5");
  c.add_option("--data", o.data_directory, "Base folder of relative mesh file names");
  add_repeated("--set", o.overrides, "key=value, overrides the job file; may be repeated");
  add_term("--unit", o.unit, {"mm", "cm", "m"}, "Unit of lengths");
  add_term("--angles", o.angles, {"deg", "rad"}, "Unit of angles");
  add_term("--order", o.order, {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"},
           "Order of the rotations about the body's own axes: zxy is R = Rz Rx Ry");
  add_term("--direction", o.direction, {"moving-in-reference", "reference-in-moving"}, "Whose pose it is");
  add_term("--axes", o.axes, {"canonical", "files"},
           "Axes and origins: those of the motion model, or of the mesh files before the frames of the job");
  add_term("--side", o.side, {"right", "left"}, "Side for which the signs of the table hold");
  add_term("--lengths", o.lengths, {"origin", "centre", "grood-suntay"},
           "Lengths of the moving origin, of the rotation centre, or along the Grood-Suntay axes");
  c.add_option("--key", o.key, "Column of the frames' keys; default: time, frame, gait_percent, ...");
  add_repeated("--column", o.columns,
               "COORDINATE=COLUMN: column of flexion, varus, internal, rx, ry, rz, tx, ty, tz, ...; "
               "COORDINATE=-COLUMN: with the opposite sign; may be repeated");
  c.add_option("--moving-prefix", o.moving_prefix, "Before T11 to T34 of the moving object: tibia_");
  c.add_option("--reference-prefix", o.reference_prefix,
               "The same of the reference, where both are posed in a common frame");
  c.add_option("--reference-motion", o.reference_motion,
               "File with the poses of the reference in a common frame");
  c.add_flag("--replace", o.may_replace, "Replace another result");
  add_threads(c, o.n_threads);
  c.add_flag("--json", o.as_json, "Print JSON");
}

}  // namespace vrda::app
