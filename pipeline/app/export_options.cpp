// The options of `vrda export`.
#include <CLI/CLI.hpp>

#include "app/file_commands.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void add_export_options(CLI::App& c, ExportOptions& e)
{
  c.add_option("file", e.file, "Motion model (HDF5)")->required();
  c.add_option("--to", e.format,
               "sto or mot (OpenSim motion), osim (OpenSim model), csv, gltf (.glb) or vtk (.pvd, ParaView)")
      ->required()
      ->check(one_of({"sto", "mot", "osim", "csv", "gltf", "vtk"}));
  c.add_option("-o,--output", e.output, "Output file, with the extension of the format")->required();
  c.add_option("--set", e.set,
               "two_sided, raw, degree_N, ...; default: the default motion of the model (vrda info)");
  c.add_option("--flexion", e.flexion, "FROM:TO:STEP, degrees; default: the flexions of the model");
  c.add_option("--varus", e.varus,
               "Degrees, spine (balanced) or zero (the zero-varus table); default: spine for the raw poses, "
               "else zero if the table exists; in osim also driven: a second coordinate of the joint");
  c.add_option("--coordinate", e.coordinates,
               "COORDINATE=NAME: column name of flexion, varus, internal, tx, ty or tz in sto and mot, "
               "coordinate name of flexion in osim; -NAME negates it; may be repeated")
      ->allow_extra_args(false)
      ->take_all();
  c.add_flag("--degrees", e.in_degrees, "Angles of sto and mot in degrees; default: radians");
  c.add_option(
       "--translations", e.translations,
       "Point of tx, ty, tz in sto and mot: rotation-centre, or mesh-origin for joints without offset frames")
      ->check(one_of({"rotation-centre", "mesh-origin"}))
      ->capture_default_str();
  c.add_option("--rate", e.degrees_per_second,
               "Flexion rate that sets time in sto, mot and gltf, degrees per second")
      ->check(number(1e-3, 1e6))
      ->capture_default_str();
  c.add_flag("--joint-only", e.only_joint, "osim: write only the joint, to paste into a model");
  c.add_flag("--full", e.every_cell, "csv: one row per grid cell, with all of its values");
  c.add_flag("--json", e.as_json, "Print JSON");
}

}  // namespace vrda::app
