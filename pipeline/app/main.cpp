/// The command line of `vrda`, and the only place in the program that handles exceptions.
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>

#include "app/bands_command.hpp"
#include "app/cluster_options.hpp"
#include "app/file_commands.hpp"
#include "app/fit_command.hpp"
#include "app/import_command.hpp"
#include "app/laxity_command.hpp"
#include "app/model_commands.hpp"
#include "app/repair_command.hpp"
#include "app/rom_command.hpp"
#include "app/score_command.hpp"
#include "app/usage.hpp"
#include "core/console.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "run/run_command.hpp"
#include "store/motion.hpp"
#include "store/read_separately.hpp"

namespace {

using vrda::core::ExitCode;

constexpr const char* help_footer = R"(Example:
  vrda run jobs/knee-generic.toml
`vrda COMMAND --help` shows an example of each command.

Exit codes:
  0  done
  2  bad input; the message names file, field, the value found and the value wanted
  3  finished, but incomplete: too many unsolved attitudes, a fit or repair that did not converge, or an
     unsolved laxity test
  4  interrupted; repeat the same command to resume
  5  internal error; the message says what to report)";

struct Commands {
  CLI::App app{"VRDA: computes a motion model of a joint from its surface meshes.", "vrda"};
  vrda::run::RunOptions run;
  vrda::run::MergeOptions merge;
  vrda::app::CheckOptions check;
  vrda::app::InfoOptions info;
  vrda::app::InfoOptions validate;
  vrda::app::CompareCommandOptions compare;
  vrda::app::ShapeOptions shape;
  vrda::app::TraceOptions trace;
  vrda::app::ReduceOptions reduce;
  vrda::app::RepairCommandOptions repair;
  vrda::app::RomOptions rom;
  vrda::app::ReportOptions report;
  vrda::app::SmoothCommandOptions smooth;
  vrda::app::AuditOptions audit;
  vrda::app::ExportOptions exported;
  vrda::app::ImportOptions imported;
  vrda::app::FitCommandOptions fit;
  vrda::app::LaxityOptions laxity;
  vrda::app::ScoreCommandOptions score;
  vrda::app::BandsOptions bands;
  vrda::app::PrepareOptions prepare;
  vrda::app::ConvertObjectOptions object;
  vrda::app::ConvertMeshOptions mesh;
  vrda::app::ConvertConfigOptions config;
  vrda::app::ClusterOptions cluster;
  bool is_quiet = false;
  std::function<ExitCode()> chosen;

  CLI::App& add(const std::string& name, const std::string& what, const std::string& example)
  {
    return add_to(app, name, what, example);
  }

  CLI::App& add_to(CLI::App& parent, const std::string& name, const std::string& what,
                   const std::string& example)
  {
    CLI::App& command = *parent.add_subcommand(name, what);
    command.footer("Example:\n  " + example);
    command.add_flag("-q,--quiet", is_quiet, "Results, warnings and errors only");
    return command;
  }

  /// Adds a command that opens motion models.
  CLI::App& add_reading(const std::string& name, const std::string& what, const std::string& example)
  {
    CLI::App& command = add(name, what, example);
    command.add_flag_callback(
        "--unsealed", [] { vrda::store::accept_unsealed_files(); },
        "Also read files without a seal: files that another program wrote or changed");
    return command;
  }

  void add_run()
  {
    CLI::App& c =
        add("run", "Solve every attitude of a job and write its motion model; resumes from a journal.",
            "vrda run jobs/knee-generic.toml --threads 2");
    vrda::app::add_run_options(c, run);
    c.callback([this] {
      chosen = [this] {
        if (is_quiet) run.progress = "none";
        return vrda::run::run_command(run);
      };
    });
  }

  void add_merge()
  {
    CLI::App& c = add("merge", "Build the motion model from the journals of shards.",
                      "vrda merge -o results/knee-generic/knee-generic.h5");
    c.add_option("journals", merge.journals, "Journals; default: those of the spine and shards next to FILE");
    c.add_option("-o,--output", merge.output, "Motion model to write")->required();
    c.add_option("--job", merge.job_file,
                 "Job file (TOML); default: as recorded in the case file next to the journals");
    c.add_option("--data", merge.data_directory, "With --job: base folder of relative mesh file names");
    c.add_option("--set", merge.overrides, "With --job: key=value, overrides the job file; may be repeated")
        ->allow_extra_args(false)
        ->take_all();
    c.add_option("--threads", merge.n_threads, "Threads for smoothing; default: one per processor")
        ->check(vrda::app::whole_number(1, 1024));
    c.add_flag("--keep", merge.keeps_journals, "Keep the journals");
    c.add_flag("--replace", merge.may_replace, "Replace the result of another job");
    c.callback([this] { chosen = [this] { return vrda::run::merge_command(merge); }; });
  }

  void add_check()
  {
    CLI::App& c = add("check", "Print the job as read, the plan and warnings; solve nothing.",
                      "vrda check jobs/knee-generic.toml --picture knee.png");
    c.add_option("job", check.job_file, "Job file (TOML)")->required();
    c.add_option("--data", check.data_directory, "Base folder of relative mesh file names");
    vrda::app::add_overrides(c, check.overrides);
    c.add_option("--picture", check.picture,
                 "PNG file to draw: bones, axes, rotation centre, push and fibres in two views");
    c.add_flag("--json", check.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return check_command(check); }; });
  }

  void add_info()
  {
    CLI::App& c = add_reading("info", "Summarise a motion model; measure gaps and penetrations again.",
                              "vrda info results/knee-generic/knee-generic.h5");
    c.add_option("file", info.file, "Motion model (HDF5)")->required();
    c.add_flag("--json", info.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return info_command(info); }; });
  }

  void add_validate()
  {
    CLI::App& c = add_reading(
        "validate", "Check a file against schemas/motion-model.md, or a trace against schemas/trace.md.",
        "vrda validate results/knee-generic/knee-generic.h5");
    c.add_option("file", validate.file, "Motion model or trace (HDF5)")->required();
    c.add_flag("--json", validate.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return validate_command(validate); }; });
  }

  void add_smooth()
  {
    CLI::App& c =
        add_reading("smooth",
                    "Add smoothed surfaces of one degree to a motion model; replaces existing surfaces of "
                    "that degree.",
                    "vrda smooth results/knee-generic/knee-generic.h5 --degree 6 --recontact");
    c.add_option("file", smooth.file, "Motion model (HDF5)")->required();
    c.add_option("--degree", smooth.degree, "Total degree of the polynomials")
        ->required()
        ->check(vrda::app::whole_number(0, vrda::store::max_smoothed_degree));
    c.add_flag("--robust", smooth.is_robust, "Reduce the weight of outliers (Huber)");
    c.add_flag("--recontact", smooth.is_recontacted,
               "Also find the travel along Delta into contact at every attitude");
    vrda::app::add_threads(c, smooth.n_threads);
    c.add_flag("--json", smooth.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return smooth_command(smooth); }; });
  }

  void add_audit()
  {
    CLI::App& c = add_reading(
        "audit", "Measure gap and penetration of the motions in a motion model; store the result in it.",
        "vrda audit results/knee-generic/knee-generic.h5 --set degree_6 --refine 4");
    c.add_option("file", audit.file, "Motion model (HDF5)")->required();
    c.add_option("--set", audit.set, "two_sided, raw, degree_N, degree_N_recontacted, zero_varus or all")
        ->capture_default_str();
    c.add_option("--refine", audit.refine, "Subdivisions of each grid cell along each axis")
        ->check(vrda::app::whole_number(1, 100))
        ->capture_default_str();
    vrda::app::add_threads(c, audit.n_threads);
    c.add_flag("--json", audit.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return audit_command(audit); }; });
  }

  void add_trace()
  {
    CLI::App& c = add_reading("trace", "Summarise the searches of a trace, or print their moves as CSV.",
                              "vrda trace results/knee-generic/knee-generic.trace.h5 --flexion 45 --csv");
    trace.add_to(c);
    c.callback([this] { chosen = [this] { return trace_command(trace); }; });
  }

  void add_reduce()
  {
    CLI::App& c = add_reading(
        "reduce",
        "Add the flexion-only motion with both condyles in contact to a motion model; print it as CSV "
        "with axes of rotation, rolling and sliding.",
        "vrda reduce results/knee-generic/knee-generic.h5 --set degree_6");
    c.add_option("file", reduce.file, "Motion model (HDF5)")->required();
    c.add_option("--set", reduce.set, "Source of the poses: raw, two_sided, degree_N, ...")
        ->capture_default_str();
    c.add_flag("--json", reduce.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return reduce_command(reduce); }; });
  }

  void add_repair()
  {
    CLI::App& c = add_reading("repair",
                              "Find the motion nearest to a measured one, in units of its noise, that "
                              "neither overlaps nor separates.",
                              "vrda repair measured.h5 -o repaired.h5 --noise-mm 0.5 --noise-deg 1");
    vrda::app::add_repair_options(c, repair);
    c.callback([this] { chosen = [this] { return repair_command(repair); }; });
  }

  void add_rom()
  {
    CLI::App& c =
        add("rom", "Find the rotations that the joint can reach within limits, and what prevents the others.",
            "vrda rom jobs/hip-generic.toml -o rom/hip --flexion -120:20:5 --varus "
            "-45:45:5");
    vrda::app::add_rom_options(c, rom);
    c.callback([this] { chosen = [this] { return rom_command(rom); }; });
  }

  void add_report()
  {
    CLI::App& c = add_reading("report", "Write motion models as one HTML page with plots, DIR/index.html.",
                              "vrda report results/knee-generic/knee-generic.h5 -o report");
    c.add_option("files", report.files, "Motion models (HDF5); several are compared")->required();
    c.add_option("-o,--output", report.folder, "Output folder")->required();
    c.add_option("--against", report.against, "Curve over flexion (CSV) to compare with; may be repeated")
        ->allow_extra_args(false)
        ->take_all();
    c.add_option("--player", report.player,
                 "Path of vrda-player, which draws the pictures; default: next to vrda");
    c.add_flag("--quick", report.is_quick, "Skip the audit of each smoothing degree");
    c.add_flag("--json", report.as_json, "Print the page's data as JSON");
    c.callback([this] { chosen = [this] { return report_command(report); }; });
  }

  void add_compare()
  {
    CLI::App& c =
        add_reading("compare", "Compare smoothing degrees and recommend one; does not change the file.",
                    "vrda compare results/knee-generic/knee-generic.h5 --degrees 1..12");
    c.add_option("file", compare.file, "Motion model (HDF5)")->required();
    c.add_option("--degrees", compare.degrees, "A range or a list: 1..12 or 2,4,6")->capture_default_str();
    c.add_option("--refine", compare.refine,
                 "Subdivisions of a grid step at which gap and penetration are measured; 0: no audit")
        ->check(vrda::app::whole_number(0, 16))
        ->capture_default_str();
    vrda::app::add_threads(c, compare.n_threads);
    c.add_flag("--robust", compare.is_robust, "Fit with Huber weights, which reduce the effect of outliers");
    c.add_flag("--recontact", compare.is_recontacted,
               "Compare the motions after moving them into contact along Delta");
    c.add_flag("--json", compare.as_json, "Print JSON");
    c.callback([this] { chosen = [this] { return compare_command(compare); }; });
  }

  void add_export()
  {
    CLI::App& c = add_reading(
        "export", "Write the motion of a motion model for OpenSim, ParaView, spreadsheets or glTF viewers.",
        "vrda export results/knee-generic/knee-generic.h5 --to gltf -o knee.glb");
    vrda::app::add_export_options(c, exported);
    c.callback([this] { chosen = [this] { return export_command(exported); }; });
  }

  void add_import()
  {
    CLI::App& c =
        add("import",
            "Make a motion model from a measured motion; determines what the table does not state: units, "
            "order, direction, axes and side.",
            "vrda import knee.toml --motion fluoroscopy.csv --order zxy -o measured.h5");
    vrda::app::add_import_options(c, imported);
    c.callback([this] { chosen = [this] { return import_command(imported); }; });
  }

  void add_fit()
  {
    CLI::App& c = add_reading(
        "fit",
        "Estimate inputs of a job from measurements: strains, loads and attachments of "
        "[[fit.parameter]] from motions and laxities, or offset_mm = \"fit\" from poses in contact.",
        "vrda fit knee.toml --to measured.csv -o fitted.toml");
    fit.add_to(c);
    c.callback([this] { chosen = [this] { return fit_command(fit); }; });
  }

  void add_laxity()
  {
    CLI::App& c = add("laxity",
                      "Apply the loads of [laxity] at held flexions: how far the joint moves, and which "
                      "fibres resist.",
                      "vrda laxity knee.toml -o laxity --against published.csv");
    laxity.add_to(c);
    c.callback([this] { chosen = [this] { return laxity_command(laxity); }; });
  }

  void add_bands()
  {
    CLI::App& c =
        add_reading("bands",
                    "Print the bands of an uncertain job over flexion (quantiles of the results of its "
                    "samples), or the share of their variance that each random input explains.",
                    "vrda bands results/my-knee/my-knee.h5 --table shares");
    bands.add_to(c);
    c.callback([this] { chosen = [this] { return bands_command(bands); }; });
  }

  void add_score()
  {
    CLI::App& c = add_reading("score", "Compare a motion with a measured one, coordinate by coordinate.",
                              "vrda score knee.h5 --against measured.csv --align constant");
    score.add_to(c);
    c.callback([this] { chosen = [this] { return score_command(score); }; });
  }

  void add_shape()
  {
    CLI::App& c = add("shape", "Write a generated joint as STL files.",
                      "vrda shape knee -o knee side=left resolution=2");
    c.footer("Example:\n  vrda shape knee -o knee side=left resolution=2\n\n" + vrda::app::shape_help());
    c.add_option("shape", shape.shape, "Name of the shape")->required();
    c.add_option("parameters", shape.parameters, "name=value");
    c.add_option("-o,--output", shape.folder, "Output folder")->required();
    c.add_flag("--ligaments", shape.has_ligaments, "Also write ligaments.csv (knee)");
    c.callback([this] { chosen = [this] { return shape_command(shape); }; });
  }

  void add_prepare()
  {
    CLI::App& c =
        add("prepare",
            "Make a job from meshes of femur and tibia: finds unit, side and anatomical frames, transfers "
            "the ligaments of a template.",
            "vrda prepare --femur femur.stl --tibia tibia.stl -o my-knee");
    vrda::app::add_prepare_options(c, prepare);
    c.callback([this] { chosen = [this] { return prepare_command(prepare); }; });
  }

  void add_convert()
  {
    CLI::App& convert = add("convert", "Convert the thesis's formats, or a mesh file to another format.",
                            "vrda convert mesh femur.stl femur.vf");
    convert.require_subcommand(1);
    CLI::App& o = add_to(convert, "object",
                         "Split an Object set (PREFIX.coor, .norm, .elem) into one Vertices-Faces file per "
                         "component; print the counts of polygons and triangles.",
                         "vrda convert object knee -o models");
    o.add_option("prefix", object.prefix, "Common path of the three files, without extension")->required();
    o.add_option("-o,--output", object.folder, "Output folder")->required();
    o.callback([this] { chosen = [this] { return convert_object_command(object); }; });

    CLI::App& m = add_to(convert, "mesh", "Write a mesh in another format, selected by the extension.",
                         "vrda convert mesh femur.stl femur.vf");
    m.add_option("input", mesh.input, "STL, PLY, OBJ (Wavefront or Vertices-Faces) or VF")->required();
    m.add_option("output", mesh.output, ".vf, .stl, .ply or .obj (Wavefront)")->required();
    m.callback([this] { chosen = [this] { return convert_mesh_command(mesh); }; });

    CLI::App& c = add_to(convert, "config", "Convert a keyword configuration (thesis, appendix B) to a job.",
                         "vrda convert config knee.cfg -o knee.toml");
    c.add_option("file", config.file, "Configuration file")->required();
    c.add_option("-o,--output", config.output, "Job file (TOML) to write")->required();
    c.add_option("--unit", config.unit, "Unit of the configuration's lengths and of the meshes: m, cm or mm")
        ->check(vrda::app::one_of({"m", "cm", "mm"}))
        ->capture_default_str();
    c.callback([this] { chosen = [this] { return convert_config_command(config); }; });
  }

  Commands()
  {
    app.require_subcommand(1);
    app.footer(help_footer);
    app.set_version_flag("--version", "vrda " VRDA_VERSION);
    add_run();
    add_merge();
    cluster.add_to([this](const auto& name, const auto& what,
                          const auto& example) -> CLI::App& { return add(name, what, example); },
                   chosen);
    add_check();
    add_info();
    add_validate();
    add_smooth();
    add_audit();
    add_trace();
    add_reduce();
    add_repair();
    add_rom();
    add_report();
    add_compare();
    add_export();
    add_import();
    add_fit();
    add_laxity();
    add_score();
    add_bands();
    add_prepare();
    add_shape();
    add_convert();
  }
};

int as_int(ExitCode code)
{
  return static_cast<int>(code);
}

// The next file opened would reuse the descriptor of a closed stream and receive the printed text. A
// descriptor opened for reading makes such a write fail.
void hold_standard_streams()
{
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDONLY) < 0) std::abort();
  }
}

void require_printed()
{
  const bool is_flushed = std::fflush(stdout) == 0;
  if (is_flushed && std::ferror(stdout) == 0) return;
  throw vrda::InputError({"standard output", "", "a write error", "a writable output"});
}

int refused(const vrda::InputError& error)
{
  std::fprintf(stderr, "vrda: %s\n", error.what());
  return as_int(ExitCode::bad_input);
}

int run_program(int argc, char** argv)
{
  Commands commands;
  try {
    commands.app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    commands.app.exit(success);
    std::cout.flush();
    require_printed();
    return as_int(ExitCode::done);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "vrda: %s\n", vrda::app::usage_message(commands.app, error).c_str());
    return as_int(ExitCode::bad_input);
  }
  if (commands.is_quiet) vrda::core::suppress_info();
  vrda::store::on_unconfined_read([](const std::string& why) {
    vrda::core::log_warning("the process that reads HDF5 runs without a sandbox on this system (" + why +
                            "); its resource limits still apply");
  });
  const ExitCode code = commands.chosen();
  require_printed();
  return as_int(code);
}

}  // namespace

int main(int argc, char** argv)
{
  hold_standard_streams();
  try {
    return run_program(argc, argv);
  } catch (const vrda::InputError& error) {
    return refused(error);
  } catch (const std::filesystem::filesystem_error& error) {
    return refused(vrda::input_error_of(error));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vrda: internal error: %s\nPlease report this with the command and the job file.\n",
                 error.what());
    return as_int(ExitCode::internal_error);
  }
}
