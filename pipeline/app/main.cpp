/// The list of the commands of `vrda`, and the only place in the program that handles exceptions.
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "app/commands.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "store/read_separately.hpp"

namespace {

using vrda::core::ExitCode;
using namespace vrda::app;

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

// In the order of the help.
constexpr CommandRow rows[] = {
    {"run", declare_run, "Solve every attitude of a job and write its motion model; resumes from a journal.",
     "vrda run jobs/knee-generic.toml --threads 2"},
    {"merge", declare_merge, "Build the motion model from the journals of shards.",
     "vrda merge -o results/knee-generic/knee-generic.h5"},
    {"plan", declare_plan,
     "Check the cases of a job or campaign and list their estimated cost; solve nothing.",
     "vrda plan jobs/campaign-example.toml"},
    {"submit", declare_submit, "Run the cases of a job or campaign as Slurm tasks or local processes.",
     "vrda submit jobs/knee-generic.toml --shards 8 --partition batch --time 30 --mem 500M\n  "
     "vrda submit jobs/knee-generic.toml --shards 8 --local"},
    {"status", declare_status, "Print the progress of a submission by task, or of a campaign by case.",
     "vrda status results/knee-generic"},
    {"resume", declare_resume, "Submit the missing tasks of a submission; given options replace its own.",
     "vrda resume results/knee-generic --time 1:00:00"},
    {"index", declare_index, "Tabulate the results of a submission: one row per case, as CSV and HDF5.",
     "vrda index results/campaign-example"},
    {"task", declare_task, "Run one task of a submission; called by its scripts and local processes.",
     "vrda task results/knee-generic --kind shard --case knee-generic --shard 3"},
    {"check", declare_check, "Print the job as read, the plan and warnings; solve nothing.",
     "vrda check jobs/knee-generic.toml --picture knee.png"},
    {"info", declare_info, "Summarise a motion model; measure gaps and penetrations again.",
     "vrda info results/knee-generic/knee-generic.h5", true},
    {"validate", declare_validate,
     "Check a file against schemas/motion-model.md, or a trace against schemas/trace.md.",
     "vrda validate results/knee-generic/knee-generic.h5", true},
    {"smooth", declare_smooth,
     "Add smoothed surfaces of one degree to a motion model; replaces existing surfaces of "
     "that degree.",
     "vrda smooth results/knee-generic/knee-generic.h5 --degree 6 --recontact", true},
    {"audit", declare_audit,
     "Measure gap and penetration of the motions in a motion model; store the result in it.",
     "vrda audit results/knee-generic/knee-generic.h5 --set degree_6 --refine 4", true},
    {"trace", declare_trace, "Summarise the searches of a trace, or print their moves as CSV.",
     "vrda trace results/knee-generic/knee-generic.trace.h5 --flexion 45 --csv", true},
    {"reduce", declare_reduce,
     "Add the flexion-only motion with both condyles in contact to a motion model; print it as CSV "
     "with axes of rotation, rolling and sliding.",
     "vrda reduce results/knee-generic/knee-generic.h5 --set degree_6", true},
    {"repair", declare_repair,
     "Find the motion nearest to a measured one, in units of its noise, that "
     "neither overlaps nor separates.",
     "vrda repair measured.h5 -o repaired.h5 --noise-mm 0.5 --noise-deg 1", true},
    {"rom", declare_rom,
     "Find the rotations that the joint can reach within limits, and what prevents the others.",
     "vrda rom jobs/hip-generic.toml -o rom/hip --flexion -120:20:5 --varus "
     "-45:45:5"},
    {"report", declare_report, "Write motion models as one HTML page with plots, DIR/index.html.",
     "vrda report results/knee-generic/knee-generic.h5 -o report", true},
    {"compare", declare_compare, "Compare smoothing degrees and recommend one; does not change the file.",
     "vrda compare results/knee-generic/knee-generic.h5 --degrees 1..12", true},
    {"export", declare_export,
     "Write the motion of a motion model for OpenSim, ParaView, spreadsheets or glTF viewers.",
     "vrda export results/knee-generic/knee-generic.h5 --to gltf -o knee.glb", true},
    {"import", declare_import,
     "Make a motion model from a measured motion; determines what the table does not state: units, "
     "order, direction, axes and side.",
     "vrda import knee.toml --motion fluoroscopy.csv --order zxy -o measured.h5"},
    {"fit", declare_fit,
     "Estimate inputs of a job from measurements: strains, loads and attachments of "
     "[[fit.parameter]] from motions and laxities, or offset_mm = \"fit\" from poses in contact.",
     "vrda fit knee.toml --to measured.csv -o fitted.toml", true},
    {"laxity", declare_laxity,
     "Apply the loads of [laxity] at held flexions: how far the joint moves, and which "
     "fibres resist.",
     "vrda laxity knee.toml -o laxity --against published.csv"},
    {"score", declare_score, "Compare a motion with a measured one, coordinate by coordinate.",
     "vrda score knee.h5 --against measured.csv --align constant", true},
    {"bands", declare_bands,
     "Print the bands of an uncertain job over flexion (quantiles of the results of its "
     "samples), or the share of their variance that each random input explains.",
     "vrda bands results/my-knee/my-knee.h5 --table shares", true},
    {"prepare", declare_prepare,
     "Make a job from the meshes of two bones: finds unit, side and anatomical frames. Of femur and tibia, "
     "with the ligaments of a template; --joint: of a hip, an ankle or a subtalar joint.",
     "vrda prepare --femur femur.stl --tibia tibia.stl -o my-knee"},
    {"shape", declare_shape, "Write a generated joint as STL files.",
     "vrda shape knee -o knee side=left resolution=2"},
    {"convert", declare_convert, "Convert the thesis's formats, or a mesh file to another format.",
     "vrda convert mesh femur.stl femur.vf"},
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
  CommandLine line({"vrda", "VRDA: computes a motion model of a joint from its surface meshes.", help_footer,
                    "vrda " VRDA_VERSION});
  for (const CommandRow& row : rows) line.add(row);
  if (const std::optional<ExitCode> ended = line.parse(argc, argv)) {
    require_printed();
    return as_int(*ended);
  }
  if (line.is_quiet()) vrda::core::suppress_info();
  vrda::store::on_unconfined_read([](const std::string& why) {
    vrda::core::log_warning("the process that reads HDF5 runs without a sandbox on this system (" + why +
                            "); its resource limits still apply");
  });
  const ExitCode code = line.run();
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
