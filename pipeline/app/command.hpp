/// The command line of a program of commands: what a command may declare, and how its values are checked. The
/// only files of the room that know CLI11 are command.cpp and this header's forward declarations.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/console.hpp"
#include "job/case.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace vrda::app {

/// Rules of one option. A wrong value is a usage error "found "13", wanted a whole number from 1 to 12" with
/// exit code 2.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& required();
  /// Limits are inclusive.
  Option& whole_number(int least, int most);
  /// Within the limits, both inclusive, or one of the words.
  Option& number(double least, double most, const std::vector<std::string>& words = {});
  Option& any_number();
  Option& one_of(const std::vector<std::string>& words);
  /// The help shows the value that the option has without being given.
  Option& shows_default();
  /// May be given several times, each with one value.
  Option& repeatable();
  /// Takes one value or several, and may be given several times.
  Option& takes_several();
  /// Takes exactly `n` values.
  Option& takes(int n);
  /// All values are in one word.
  Option& in_one_word();
  /// Commas separate several values in a word.
  Option& separated_by_commas();
  Option& excludes(const Option& other);
  Option& needs(const Option& other);
  /// The environment variable that gives the value otherwise.
  Option& from_environment(const std::string& name);
  /// What the help calls the value.
  Option& named(const std::string& type);

 private:
  CLI::Option* option_;
};

/// What a command does once its options are parsed.
using Action = std::function<core::ExitCode()>;

/// Most tasks, shards and cases that an option may ask for.
constexpr int most_tasks = 100000;

class CommandLine;

/// A command whose options are being declared. The order of the declarations is that of the help.
class Command {
 public:
  Command(CommandLine& line, CLI::App& app) : line_(&line), app_(&app) {}

  /// An object that lives as long as the command line, for the values of the options.
  template <typename Options>
  Options& options();

  /// Name "file" is a positional argument, "-o,--output" an option. Value: std::string, int, double,
  /// std::optional<double>, or a vector of texts or numbers.
  template <typename Value>
  Option option(const std::string& name, Value& value, const std::string& what);
  /// Calls `take` with the value of the option.
  Option option_for(const std::string& name, std::function<void(const std::string&)> take,
                    const std::string& what);
  Option flag(const std::string& name, bool& value, const std::string& what);
  /// Calls `set` if the flag is given.
  void flag_for(const std::string& name, std::function<void()> set, const std::string& what);

  // Options of the same meaning in several commands.
  Option job(std::string& file, const std::string& what = "Job file (TOML)");
  Option data(std::string& folder, const std::string& what = "Base folder of relative mesh file names");
  Option overrides(std::vector<std::string>& keys);  ///< --set key=value of a job
  /// --data and --set.
  void loading(job::LoadOptions& options,
               const std::string& what = "Base folder of relative mesh file names");
  Option model(std::string& file, const std::string& what = "Motion model (HDF5)");
  /// JOB, --data, --set and --shards of the commands that run many cases.
  void cases(job::JobSource& source, int& n_shards);
  Option threads(int& n, const std::string& what = "Worker threads; default: one per processor");
  Option progress(std::string& style);
  Option json(bool& is_json, const std::string& what = "Print JSON");

  /// Text after the options in the help, instead of the example.
  void footer(const std::string& text);
  /// What happens if the user gives this command.
  void runs(Action action);
  /// Whether --quiet was given; known once the options are parsed.
  bool is_quiet() const;
  /// A command below this one, of which one must then be given.
  Command add(const std::string& name, const std::string& what, const std::string& example);

 private:
  CommandLine* line_;
  CLI::App* app_;
};

/// A command in the list of a program.
struct CommandRow {
  const char* name;
  void (*declare)(Command&);  ///< declares the options and the action
  const char* what;           ///< a sentence for the help
  const char* example;
  bool reads_models = false;  ///< has --unsealed
};

/// The texts of a program.
struct ProgramText {
  const char *name, *what, *footer, *version;
};

class CommandLine {
 public:
  explicit CommandLine(const ProgramText& text);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  void add(const CommandRow& row);
  /// The exit code if the program ends here: after --help or --version, or after a usage error, which is one
  /// line on standard error that names the command or argument and ends with the matching --help command.
  std::optional<core::ExitCode> parse(int argc, char** argv);
  bool is_quiet() const { return is_quiet_; }
  /// Runs the command that was given.
  core::ExitCode run() const { return chosen_(); }

 private:
  friend class Command;
  CLI::App& add_to(CLI::App& parent, const std::string& name, const std::string& what,
                   const std::string& example);

  std::unique_ptr<CLI::App> app_;
  bool is_quiet_ = false;
  Action chosen_;
  std::vector<std::shared_ptr<void>> options_;
};

template <typename Options>
Options& Command::options()
{
  const auto made = std::make_shared<Options>();
  line_->options_.push_back(made);
  return *made;
}

}  // namespace vrda::app
