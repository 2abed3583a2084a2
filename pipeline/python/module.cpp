// The extension module vrda._core: jobs, single attitudes and the commands on motion models (README.md).
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <future>
#include <mutex>
#include <nlohmann/json.hpp>
#include <regex>
#include <utility>

#include "app/commands.hpp"
#include "core/console.hpp"
#include "core/document.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "job/job.hpp"
#include "python/errors.hpp"
#include "python/joint_solver.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"

namespace py = pybind11;

namespace vrda::python {
namespace {

using namespace pybind11::literals;

// --- messages ---

struct Message {
  bool is_warning;
  std::string line;
};

/// Lines of threads without the interpreter's lock, until a thread with it passes them on: the logger
/// keeps a record of every thread that calls it.
class Messages {
 public:
  void add(Message message)
  {
    const std::lock_guard lock(mutex_);
    lines_.push_back(std::move(message));
  }
  std::vector<Message> take()
  {
    const std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<Message> lines_;
};

Messages& waiting_messages()
{
  static Messages messages;
  return messages;
}

/// Of the logger; the name is interned, since Python's cache of attributes keeps each new name.
py::object attribute(const py::object& owner, const char* name)
{
  return py::getattr(owner, py::reinterpret_steal<py::str>(PyUnicode_InternFromString(name)));
}

/// Needs the interpreter lock. A handler of the logger that fails is reported by Python; Ctrl-C stays
/// pending.
void log_waiting_messages()
{
  bool is_interrupted = false;
  for (const Message& message : waiting_messages().take()) {
    try {
      const py::object logger = attribute(py::module_::import("logging"), "getLogger")("vrda");
      attribute(logger, message.is_warning ? "warning" : "info")("%s", message.line);
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt))
        is_interrupted = true;
      else
        error.discard_as_unraisable("vrda logger");
    }
  }
  if (is_interrupted) PyErr_SetInterrupt();
}

/// Messages go to the logger "vrda" of Python.
void receive_message(bool is_warning, const std::string& line)
{
  waiting_messages().add({is_warning, line});
  if (Py_IsInitialized() != 0 && PyGILState_Check() != 0) log_waiting_messages();
}

// --- long work ---

constexpr std::chrono::milliseconds signal_interval{50};

/// Runs handlers of pending signals (Ctrl-C). Needs the interpreter lock; throws what they raise.
void run_signal_handlers()
{
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// Runs `work` on another thread without the interpreter lock. Meanwhile this thread runs Python's signal
/// handlers and `on_wait`, with the lock. What they raise sets the flag of interruption, which ends the work,
/// and is raised once the work has ended.
template <typename Work, typename OnWait = void (*)()>
auto run_interruptibly(
    const Work& work, const OnWait& on_wait = [] {})
{
  std::exception_ptr raised;
  std::future<decltype(work())> result = std::async(std::launch::async, work);
  {
    const py::gil_scoped_release without_lock;
    while (result.wait_for(signal_interval) != std::future_status::ready) {
      if (raised) continue;
      const py::gil_scoped_acquire with_lock;
      try {
        log_waiting_messages();
        run_signal_handlers();
        on_wait();
      } catch (...) {
        raised = std::current_exception();
        core::set_interrupted(true);
      }
    }
  }
  core::set_interrupted(false);
  log_waiting_messages();
  if (!raised) return result.get();
  try {
    result.get();
  } catch (...) {  // the interruption is reported, not its consequences
  }
  std::rethrow_exception(raised);
}

void throw_if_interrupted()
{
  if (core::is_interrupted()) throw Interrupted();
}

py::object python_of(const nlohmann::ordered_json& json)
{
  const std::string text = core::json_text(json, -1);
  return py::module_::import("json").attr("loads")(text);
}

// --- arrays ---

/// A read-only view of memory that `owner` keeps alive; no copy.
template <typename Number>
py::array view_of(const Number* first, std::vector<py::ssize_t> shape, const py::handle& owner)
{
  py::array_t<Number> array(std::move(shape), first, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// Columns with several values a row, poses first.
std::array<const std::vector<double>*, 3> wide_columns(const RowResults& results)
{
  return {&results.X_reference_moving, &results.strain, &results.tension_n};
}
std::array<const std::vector<double>*, 2> wide_columns(const FollowerResults& results)
{
  return {&results.X_of_follower, &results.tension_n};
}

/// A column of `self`: (n,), or with several values a row (n, width), or (n, 4, 4).
template <typename Results, typename Number>
py::array column_of(const py::object& self, std::vector<Number> Results::*column)
{
  const auto& results = self.cast<const Results&>();
  const std::vector<Number>& values = results.*column;
  const auto n = static_cast<py::ssize_t>(results.status.size()),
             size = static_cast<py::ssize_t>(values.size());
  const auto wide = wide_columns(results);
  const auto is_values = [&](const void* other) { return other == &values; };
  if (is_values(wide.front())) return view_of(values.data(), {n, 4, 4}, self);
  if (std::any_of(wide.begin(), wide.end(), is_values)) return view_of(values.data(), {n, size / n}, self);
  return view_of(values.data(), {n}, self);
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::vector<double> values_of(const std::optional<Numbers>& array)
{
  if (!array) return {};
  return {array->data(), array->data() + array->size()};
}

// --- jobs ---

py::dict job_facts(const std::string& file, const std::vector<std::string>& overrides)
{
  const job::Job job = job::read_job(file, overrides);
  return py::dict("title"_a = job.title, "joint"_a = job.joint,
                  "side"_a = job.side == Side::left ? "left" : "right", "resolved"_a = job.resolved_text);
}

py::object check(const std::string& file, const std::string& data, const std::vector<std::string>& overrides,
                 const std::string& picture)
{
  const app::CheckOptions options{{{data, overrides}, file}, picture, true};
  return python_of(run_interruptibly([&] { return app::check_json(options); }));
}

std::string run(const std::string& file, const std::string& data, const std::vector<std::string>& overrides,
                const std::string& output, int threads, bool fresh, bool replace, const py::object& progress)
{
  run::RunOptions options;
  static_cast<job::JobSource&>(options) = {{data, overrides}, file};
  options.output = output;
  options.n_threads = threads;
  options.is_fresh = fresh;
  options.may_replace = replace;
  options.progress = "none";
  options.is_hosted = true;
  std::atomic<std::int64_t> steps = 0;  // done and total in one word, so that they are read together
  constexpr std::int64_t word = std::int64_t{1} << 32;
  options.on_progress = [&steps](int n_done, int n_total) { steps = n_total * word + n_done; };
  std::int64_t reported = 0;
  const auto report = [&] {
    const std::int64_t now = steps;
    if (progress.is_none() || now == reported) return;
    progress(now % word, now / word);
    reported = now;
  };
  const core::ExitCode code = run_interruptibly([&] { return run::run_command(options); }, report);
  if (code == core::ExitCode::interrupted) throw Interrupted();
  report();
  return run::output_path_of(output, file);
}

std::unique_ptr<JointSolver> make_joint(const std::string& file, const std::string& data,
                                        const std::vector<std::string>& overrides)
{
  return run_interruptibly([&] {
    return std::make_unique<JointSolver>(file, job::LoadOptions{data, overrides});
  });
}

RowResults solve_rows(JointSolver& joint, const Numbers& flexion, const std::optional<Numbers>& varus,
                      const std::optional<Numbers>& force_n, const std::optional<Numbers>& lateral_force_n,
                      const std::optional<Numbers>& moment_nmm,
                      const std::optional<Numbers>& varus_moment_nmm, const std::optional<Numbers>& seed)
{
  RowPlan plan;
  plan.flexion_deg = values_of(flexion);
  plan.varus_deg = values_of(varus);
  plan.loads = {values_of(force_n), values_of(lateral_force_n), values_of(moment_nmm),
                values_of(varus_moment_nmm)};
  if (seed) {
    if (seed->ndim() != 2 || seed->shape(0) != 4 || seed->shape(1) != 4)
      throw InputError({"Joint.solve", "seed", "an array of another shape", "a 4 x 4 matrix"});
    plan.seed.emplace();
    std::copy_n(seed->data(), 16, plan.seed->begin());
  }
  const py::gil_scoped_release without_lock;
  return joint.solve(plan, [] {
    const py::gil_scoped_acquire with_lock;
    run_signal_handlers();
  });
}

py::array vertices_of(const py::object& self, const Body& body)
{
  const Points& p_mm = body.contact.mesh.vertices_mm;
  return view_of(p_mm.data(), {p_mm.rows(), 3}, self);
}

py::array triangles_of(const py::object& self, const Body& body)
{
  const Triangles& t = body.contact.mesh.triangles;
  static_assert(Triangles::IsRowMajor, "viewed as rows of three");
  return view_of(t.data(), {t.rows(), 3}, self);
}

const job::Case& case_of(const py::object& self)
{
  return self.cast<const JointSolver&>().job_case();
}

// --- motion models ---

void require_intact(const std::string& file)
{
  store::read_hdf5(file);
}

py::object findings(const std::string& file)
{
  py::list list;
  for (const store::Finding& f : run_interruptibly([&] { return store::validate_hdf5(file); }))
    list.append(py::make_tuple(f.where, f.found, f.wanted));
  return list;
}

py::object smooth(const std::string& file, int degree, bool robust, bool recontact, int threads)
{
  const app::SmoothCommandOptions options{file, degree, robust, recontact, threads, true};
  const auto set = run_interruptibly([&] { return app::add_smoothed(options); });
  if (!set) throw Interrupted();
  return python_of(app::json_of(*set));
}

py::object compare(const std::string& file, const std::string& degrees, bool robust, bool recontact,
                   int refine, int threads)
{
  app::CompareCommandOptions options;
  options.file = file;
  options.degrees = degrees;
  options.is_robust = robust;
  options.is_recontacted = recontact;
  options.refine = refine;
  options.n_threads = threads;
  options.before_measuring = throw_if_interrupted;
  return python_of(run_interruptibly([&] { return app::json_of(app::compare_degrees(options)); }));
}

py::object export_model(const std::string& file, const std::string& to, const std::string& output,
                        const std::string& set, const std::string& flexion, const std::string& varus,
                        const std::vector<std::string>& coordinates, bool degrees, bool joint_only, bool full,
                        double rate, const std::string& translations)
{
  app::ExportOptions options;
  options.file = file;
  options.format = to;
  options.output = output;
  options.set = set;
  options.flexion = flexion;
  options.varus = varus;
  options.coordinates = coordinates;
  options.in_degrees = degrees;
  options.only_joint = joint_only;
  options.every_cell = full;
  options.degrees_per_second = rate;
  options.translations = translations;
  return python_of(run_interruptibly([&] { return app::write_export(options); }));
}

// --- commands that are called by the words of their command line ---

constexpr app::CommandRow commands[] = {{"prepare", app::declare_prepare, "", ""},
                                        {"score", app::declare_score, "", "", true}};

/// What is printed to a stream of the C library (stdout, stderr), until the end of the scope. Python's
/// streams are others.
class Captured {
 public:
  explicit Captured(FILE*& stream)
      : stream_(stream), before_(std::exchange(stream, open_memstream(&text_, &size_)))
  {
  }
  ~Captured()
  {
    std::fclose(std::exchange(stream_, before_));
    std::free(text_);
  }
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;
  std::string text()
  {
    std::fflush(stream_);
    return {text_, size_};
  }

 private:
  char* text_ = nullptr;
  std::size_t size_ = 0;
  FILE*& stream_;
  FILE* before_;
};

/// Commands install handlers of signals; Python's stay in place.
class PythonHandlers {
 public:
  PythonHandlers()
  {
    for (std::size_t i = 0; i < signals_.size(); ++i) sigaction(signals_[i], nullptr, &before_[i]);
  }
  ~PythonHandlers() { restore(); }
  PythonHandlers(const PythonHandlers&) = delete;
  PythonHandlers& operator=(const PythonHandlers&) = delete;
  void restore() const
  {
    for (std::size_t i = 0; i < signals_.size(); ++i) sigaction(signals_[i], &before_[i], nullptr);
  }

 private:
  std::array<int, 3> signals_{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, 3> before_{};
};

/// Of a line "vrda: FIELD: found X, wanted Y (see ...)" of the command line, or of another message of CLI11.
InputError usage_error(const std::string& command, const std::string& line)
{
  static const std::regex whole(R"((?:vrda: )?(.*?)(?: \(see [^)]*\))?\s*)"),
      form("(.*?):? ?found (.*), wanted (.*)");
  std::smatch parts;
  const std::string text = std::regex_match(line, parts, whole) ? parts[1].str() : line;
  if (std::regex_match(text, parts, form))
    return InputError({"vrda." + command, parts[1], parts[2], parts[3]});
  return InputError({"vrda." + command, "", text, "arguments of the command"});
}

/// Runs a command with --json and returns what it prints. One at a time.
py::object command(std::vector<std::string> words)
{
  const std::string name = words.front();
  words.insert(words.begin(), "vrda");
  words.emplace_back("--json");
  const PythonHandlers handlers;
  const auto work = [&] {
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    Captured output(stdout), errors(stderr);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    app::CommandLine line({"vrda", "", "", VRDA_VERSION});
    for (const app::CommandRow& row : commands) line.add(row);
    const int n = static_cast<int>(arguments.size());
    if (line.parse(n, arguments.data())) throw usage_error(name, errors.text());
    if (line.run() == core::ExitCode::interrupted) throw Interrupted();
    return output.text();
  };
  const std::string printed = run_interruptibly(work, [&] { handlers.restore(); });
  return py::module_::import("json").attr("loads")(printed);
}

// --- the module ---

template <typename Results>
py::class_<Results> class_of_rows(py::module_& module, const char* name, const char* meaning)
{
  py::class_<Results> rows(module, name, meaning);
  for_each_field<Results>([&](const auto& field) {
    rows.def_property_readonly(
        field.name, [member = field.member](const py::object& self) { return column_of(self, member); },
        field.meaning);
  });
  rows.def_property_readonly(
      "status",
      [](const Results& results) {
        py::list names;
        for (const std::int8_t code : results.status) names.append(name_of(static_cast<StepStatus>(code)));
        return py::module_::import("numpy").attr("array")(names, "dtype"_a = "U15");
      },
      "(n,) str: how each row ended: stable, no_contact, no_clearance, iteration_limit, unbounded.");
  rows.def("__len__", [](const Results& results) { return results.status.size(); });
  return rows;
}

void define_solution(py::module_& module)
{
  class_of_rows<FollowerResults>(
      module, "FollowerSolution",
      "A follower in the rows of Joint.solve; rows in which it is not stable are NaN.");
  class_of_rows<RowResults>(
      module, "Solution",
      "Rows of Joint.solve as read-only arrays without copies; rows that are not stable "
      "are NaN.")
      .def_property_readonly(
          "followers",
          [](const py::object& self) {
            py::dict named;
            for (const FollowerResults& follower : self.cast<const RowResults&>().followers)
              named[py::str(follower.name)] =
                  py::cast(&follower, py::return_value_policy::reference_internal, self);
            return named;
          },
          "Bodies that follow the joint in the same rows, by name.");
}

void define_joint(py::module_& module)
{
  py::class_<JointSolver>(module, "JointSolver", "The state of vrda.Joint.")
      .def(py::init(&make_joint), "job"_a, "data"_a, "overrides"_a)
      .def("solve", &solve_rows, "flexion"_a, "varus"_a, "force_n"_a, "lateral_force_n"_a, "moment_nmm"_a,
           "varus_moment_nmm"_a, "seed"_a)
      .def_property_readonly("method", [](const JointSolver& joint) { return joint.job_case().method; })
      .def_property_readonly("fibres", &JointSolver::fibre_names)
      .def_property_readonly("followers", &JointSolver::follower_names)
      .def("follower_fibres", &JointSolver::follower_fibre_names, "follower"_a)
      .def(
          "follower_vertices",
          [](const py::object& self, const std::string& name) {
            return vertices_of(self, self.cast<const JointSolver&>().follower(name).body);
          },
          "follower"_a)
      .def(
          "follower_triangles",
          [](const py::object& self, const std::string& name) {
            return triangles_of(self, self.cast<const JointSolver&>().follower(name).body);
          },
          "follower"_a)
      .def_property_readonly("rotation_centre",
                             [](const py::object& self) {
                               return view_of(case_of(self).frame.rotation_centre_mm.data(), {3}, self);
                             })
      .def_property_readonly(
          "reference_vertices",
          [](const py::object& self) { return vertices_of(self, case_of(self).reference); })
      .def_property_readonly(
          "reference_triangles",
          [](const py::object& self) { return triangles_of(self, case_of(self).reference); })
      .def_property_readonly("moving_vertices",
                             [](const py::object& self) { return vertices_of(self, case_of(self).moving); })
      .def_property_readonly("moving_triangles",
                             [](const py::object& self) { return triangles_of(self, case_of(self).moving); });
}

}  // namespace

PYBIND11_MODULE(_core, module)
{
  register_errors();
  core::set_log_receiver(receive_message);
  module.attr("__version__") = VRDA_VERSION;
  module.def("no_lock", [] { permit_missing_locks(core::log_warning); });
  module.def("job_facts", &job_facts, "file"_a, "overrides"_a);
  module.def("check", &check, "file"_a, "data"_a, "overrides"_a, "picture"_a);
  module.def("run", &run, "file"_a, "data"_a, "overrides"_a, "output"_a, "threads"_a, "fresh"_a, "replace"_a,
             "progress"_a);
  module.def("require_intact", &require_intact, "file"_a);
  module.def("findings", &findings, "file"_a);
  module.def("smooth", &smooth, "file"_a, "degree"_a, "robust"_a, "recontact"_a, "threads"_a);
  module.def("compare", &compare, "file"_a, "degrees"_a, "robust"_a, "recontact"_a, "refine"_a, "threads"_a);
  module.def("export", &export_model, "file"_a, "to"_a, "output"_a, "set"_a, "flexion"_a, "varus"_a,
             "coordinates"_a, "degrees"_a, "joint_only"_a, "full"_a, "rate"_a, "translations"_a);
  module.def("command", &command, "words"_a);
  define_solution(module);
  define_joint(module);
}

}  // namespace vrda::python
