// `vrda report`: figures of one or several models on one page, with images that vrda-player renders.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <limits>
#include <optional>

#include "analysis/audit.hpp"
#include "analysis/compare.hpp"
#include "analysis/flexion_curves.hpp"
#include "analysis/reduce.hpp"
#include "analysis/smooth.hpp"
#include "app/commands.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "report/report.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "store/motion.hpp"

namespace vrda::app {
namespace {

namespace fs = std::filesystem;

/// `vrda report`: writes motion models as one HTML page.
struct ReportOptions {
  std::vector<std::string> files;    ///< motion models
  std::string output;                ///< a page, *.html, or the folder of index.html
  std::vector<std::string> against;  ///< CSV files of curves
  std::string player;                ///< path of vrda-player; empty: next to this program
  bool is_quick = false;             ///< skip the audit of each smoothing degree
  bool as_json = false;              ///< print the page's data instead of the page's path
};

constexpr int n_steps = 3;  // frames per view, minus one
constexpr std::uintmax_t largest_png_bytes = 16u << 20;
// Exit codes of the player (player/app/README.md): done, and some attitudes unsolved.
constexpr int player_done = 0, player_unsolved = 3;

/// A temporary folder, removed on destruction.
class TemporaryFolder {
 public:
  TemporaryFolder()
  {
    std::error_code error;
    std::string name = (fs::temp_directory_path(error) / "vrda-report-XXXXXX").string();
    if (!error && mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Empty if it could not be created.
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// Of a sequence of frames, some of all frames.
std::string shown_range(const store::MotionModel& model)
{
  if (model.frames) {
    const std::vector<double>& keys = model.frames->key;
    const double span = keys.back() - keys.front();
    return printed("--key=%.9g:%.9g:%.9g", keys.front(), keys.back(), span > 0.0 ? span / n_steps : 1.0);
  }
  const double first = model.flexion_deg.front(), last = model.flexion_deg.back();
  const double step = last > first ? (last - first) / n_steps : 1.0;
  return printed("--flexion=%.9g:%.9g:%.9g", first, last, step);
}

// Splits "front_flexion_030.png" or "front_frame_0.5.png" into view and label; an unparsed name becomes the
// label.
report::RenderedImage still_of(const fs::path& file)
{
  const std::string name = file.stem().string();
  const bool is_frame = name.find("_frame_") != std::string::npos;
  const std::string_view between = is_frame ? "_frame_" : "_flexion_";
  report::RenderedImage still;
  const std::size_t at = name.find(between);
  still.view = name.substr(0, at);
  const std::string angle = at == std::string::npos ? "" : name.substr(at + between.size());
  double degrees = 0.0;
  const auto [end, error] = std::from_chars(angle.data(), angle.data() + angle.size(), degrees);
  const bool is_number = error == std::errc() && end == angle.data() + angle.size();
  still.label = is_number ? printed(is_frame ? "frame %.4g" : "flexion %.4g°", degrees) : name;
  still.png = job::file_bytes(file.string(), {file.string(), "", "", "a picture"}, largest_png_bytes);
  return still;
}

std::vector<report::RenderedImage> stills_in(const fs::path& folder)
{
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<report::RenderedImage> stills;
  for (const fs::path& file : files) stills.push_back(still_of(file));
  return stills;
}

}  // namespace

std::string find_player(const std::string& player)
{
  std::error_code error;
  if (!player.empty()) {
    if (!fs::is_regular_file(player, error))
      throw InputError({player, "--player", "no such program", "the path of vrda-player"});
    return fs::absolute(player).string();
  }
  const fs::path own = own_program();
  const fs::path beside = own.parent_path() / "vrda-player";
  return !own.empty() && fs::is_regular_file(beside, error) ? beside.string() : "";
}

report::RenderedImages render_images(const std::string& player, const std::string& file,
                                     const store::MotionModel& model)
{
  if (player.empty())
    return {{}, "No pictures: vrda-player is not in the folder of vrda; give its path with --player PATH."};
  const TemporaryFolder folder;
  if (folder.path().empty()) return {{}, "No pictures: no temporary folder could be created."};
  const StartedProcess started =
      start_process({player, "show", file, "--offscreen", folder.path().string(), shown_range(model),
                     "--views", "front,lateral", "--size", "440x440", "--quiet"});
  const int code = started.pid < 0 ? -1 : wait_for_process(started.pid).exit_code;
  if (code != player_done && code != player_unsolved)
    return {{},
            "No pictures: vrda-player failed" +
                (code >= 0 && started.error == 0 ? " (exit code " + std::to_string(code) + ")." : ".")};
  return {stills_in(folder.path()),
          code == player_unsolved ? "Attitudes without a pose have no picture." : ""};
}

namespace {

#ifndef VRDA_VERSION
#error "the version of the program"
#endif

// The gap alone finds most poses free, in a tenth of the time of `vrda audit`.
store::AuditSet quick_audit(const store::MotionModel& model, const std::string& set,
                            const analysis::Measuring& with)
{
  return analysis::audit(model, set, 1, with, analysis::OverlapTest::sweep);
}

// The audit of the raw motion at the grid's attitudes: from the file, otherwise measured now.
store::AuditSet raw_audit(const store::MotionModel& model, const analysis::Measuring& with)
{
  for (const store::AuditSet& stored : model.audits) {
    if (stored.name == "raw" && stored.refine == 1) return stored;
  }
  return quick_audit(model, "raw", with);
}

report::RawExtremes raw_extremes(const store::AuditSet& raw)
{
  const analysis::AuditFigures figures = analysis::figures_of(raw);
  const double gap_mm =
      figures.n_nothing_ahead > 0 ? std::numeric_limits<double>::infinity() : figures.largest_gap.value_mm;
  return {figures.n_overlapping, figures.largest_penetration.value_mm, gap_mm};
}

// Empty if the solved cells cannot determine even degree 1.
std::optional<analysis::Comparison> comparison_of(const store::MotionModel& model,
                                                  const ReportOptions& options,
                                                  const analysis::Measuring& with)
{
  if (model.frames) return std::nullopt;
  if (analysis::largest_degree(analysis::smooth_input(model, options.files.front())) < 1) return std::nullopt;
  analysis::CompareOptions compare_with;
  compare_with.name = options.files.front();
  if (!options.is_quick) {
    compare_with.contact = run::contact_measure(with);
    // The page has no faults of followers.
    compare_with.audit = [&with](const store::MotionModel& fitted, const std::string& set) {
      return analysis::audit_joint(fitted, set, 1, with, analysis::OverlapTest::sweep);
    };
  }
  return analysis::compare(model, compare_with);
}

// Adds the audits that are missing from the file, of which `raw` is measured already.
void add_audits(store::MotionModel& model, const store::AuditSet& raw, const analysis::Measuring& with)
{
  for (const std::string& set : store::set_names(model)) {
    const bool is_there = std::any_of(model.audits.begin(), model.audits.end(),
                                      [&](const store::AuditSet& a) { return a.name == set; });
    if (!is_there) model.audits.push_back(set == raw.name ? raw : quick_audit(model, set, with));
  }
}

// Distinguishes files of the same name in different folders.
std::string unique_name(const std::vector<report::ReportModel>& models, const std::string& file)
{
  const std::string stem = std::filesystem::path(file).stem().string();
  std::string name = stem;
  for (int k = 2; std::any_of(models.begin(), models.end(), [&](const auto& m) { return m.name == name; });
       ++k)
    name = stem + " (" + std::to_string(k) + ")";
  return name;
}

// The report starts with the flexion-only motion; if the file has none, it is reduced from the raw cells.
store::MotionModel reduced(store::MotionModel model)
{
  if (model.zero_varus || !analysis::is_reducible(model)) return model;
  store::ZeroVarus zero_varus = analysis::reduce(model, "raw");
  if (analysis::n_reduced_flexions(zero_varus) > 0) model.zero_varus = std::move(zero_varus);
  return model;
}

std::vector<report::ReportModel> models_of(const ReportOptions& options)
{
  std::vector<report::ReportModel> models;
  for (const std::string& file : options.files) {
    report::ReportModel entry;
    entry.name = unique_name(models, file);
    entry.model = reduced(run::read_solved_model(file));
    models.push_back(std::move(entry));
  }
  return models;
}

// Curves over flexion and over a key have no common axis.
void require_alone(const report::Report& report, const ReportOptions& options)
{
  const bool is_compared = report.models.size() > 1 || !options.against.empty();
  for (std::size_t i = 0; is_compared && i < report.models.size(); ++i)
    store::require_grid(report.models[i].model, options.files[i], "a comparison over flexion");
}

report::Report gathered(const ReportOptions& options)
{
  report::Report report;
  report.program = "vrda " VRDA_VERSION;
  report.models = models_of(options);
  require_alone(report, options);
  for (const std::string& file : options.against) report.against.push_back(report::read_curve_file(file));
  const std::string player = find_player(options.player);
  const int n_threads = run::thread_count_or_all(0);
  if (report.models.size() > 1) {
    for (report::ReportModel& entry : report.models)
      entry.raw = raw_extremes(raw_audit(entry.model, n_threads));
  } else {
    report::ReportModel& only = report.models.front();
    analysis::AuditScenes scenes(only.model, n_threads);
    const analysis::Measuring with(n_threads, &scenes);
    const store::AuditSet raw = raw_audit(only.model, with);
    only.raw = raw_extremes(raw);
    // The player draws meanwhile.
    std::future<report::RenderedImages> images = std::async(
        std::launch::async, [&] { return render_images(player, options.files.front(), only.model); });
    only.comparison = comparison_of(only.model, options, with);
    if (!options.is_quick) add_audits(only.model, raw, with);
    only.flexion_curves = analysis::spine_curves(only.model, n_threads);
    only.images = images.get();
    if (!only.images.note.empty()) core::log_warning(only.images.note);
  }
  return report;
}

fs::path page_file(const fs::path& output)
{
  std::error_code unreadable;  // refused where the page is written
  const bool is_page = output.extension() == ".html" && !fs::is_directory(output, unreadable);
  return is_page ? output : output / "index.html";
}

// Writes the page and prints its path. Writes nothing if a file is unreadable or has no solved attitude.
core::ExitCode report_command(const ReportOptions& options)
{
  const report::Report report = gathered(options);
  for (const report::ReportModel& entry : report.models) {
    for (const std::string& line : report::warnings_of(entry)) core::log_info(entry.name + ": " + line);
  }
  const std::string file = page_file(options.output).string();
  run::make_parent_folder(file);
  const core::ExitCode code = run::publish(file, "vrda report", report::report_page(report));
  std::printf("%s\n", options.as_json ? report::report_json(report).c_str() : file.c_str());
  return code;
}

}  // namespace

void declare_report(Command& c)
{
  auto& o = c.options<ReportOptions>();
  c.option("files", o.files, "Motion models (HDF5); several are compared").required();
  c.option("-o,--output", o.output, "Page to write, *.html, or the folder of its index.html").required();
  c.option("--against", o.against, "Curve over flexion (CSV) to compare with; may be repeated").repeatable();
  c.option("--player", o.player, "Path of vrda-player, which draws the pictures; default: next to vrda");
  c.flag("--quick", o.is_quick, "Skip the audit of each smoothing degree");
  c.json(o.as_json, "Print the page's data as JSON");
  c.runs([&o] { return report_command(o); });
}

}  // namespace vrda::app
