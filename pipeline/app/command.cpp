#include "app/command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "core/files.hpp"
#include "core/text.hpp"
#include "store/read_separately.hpp"

namespace vrda::app {
namespace {

// `description` appears in the help.
CLI::Validator with_message(const CLI::Validator& check, const std::string& wanted,
                            const std::string& description)
{
  return {[check, wanted](std::string& word) {
            return check(word).empty() ? "" : "found \"" + word + "\", wanted " + wanted;
          },
          description};
}

CLI::Validator with_message(const CLI::Validator& check, const std::string& wanted)
{
  return with_message(check, wanted, check.get_description());
}

// The innermost parsed command: the program, `convert`, `convert mesh`.
const CLI::App& innermost(const CLI::App& app)
{
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  return chosen.empty() ? app : innermost(*chosen.back());
}

std::string unknown_command(const CLI::App& app)
{
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    known.push_back(command->get_name());
  const std::vector<std::string> extra = app.remaining();
  const std::string found = extra.empty() ? "nothing" : "\"" + extra.front() + "\"";
  return InputError({"command", "", found, join_alternatives(known)}).what();
}

// Message for an argument that neither `app` nor its parents accept.
std::string unknown_argument(const CLI::App& app, const std::string& word)
{
  if (!word.starts_with('-'))
    return InputError({app.get_name(), "", '"' + word + '"', "no further argument"}).what();
  std::vector<std::string> known;
  for (const CLI::Option* option :
       app.get_options([](const CLI::Option* o) { return !o->get_lnames().empty(); }))
    known.push_back("--" + option->get_lnames().front());
  return InputError({app.get_name(), "", '"' + word + '"',
                     "a valid option; the nearest is \"" + nearest_word(word, known) + '"'})
      .what();
}

std::string full_name(const CLI::App& app)
{
  return (app.get_parent() == nullptr ? "" : full_name(*app.get_parent()) + " ") + app.get_name();
}

std::string usage_message(const CLI::App& app, const CLI::ParseError& error)
{
  const CLI::App& reached = innermost(app);
  std::string what = error.what();
  if (reached.get_require_subcommand_min() > 0) {
    what = unknown_command(reached);
  } else if (const std::vector<std::string> left = reached.remaining(); !left.empty()) {
    what = unknown_argument(reached, left.front());
  }
  return what + " (see " + full_name(reached) + " --help)";
}

}  // namespace

Option& Option::required()
{
  option_->required();
  return *this;
}

Option& Option::whole_number(int least, int most)
{
  option_->check(with_message(CLI::Range(least, most), "a whole number from " + std::to_string(least) +
                                                           " to " + std::to_string(most)));
  return *this;
}

Option& Option::number(double least, double most, const std::vector<std::string>& words)
{
  const std::string range = "a number from " + shortest_decimal(least) + " to " + shortest_decimal(most);
  std::vector<std::string> alternatives = words;
  alternatives.push_back(range);
  const CLI::Validator within = CLI::Range(least, most);
  option_->check(words.empty() ? with_message(within, range)
                               : with_message(CLI::Validator(CLI::IsMember(words)) | within,
                                              join_alternatives(alternatives)));
  return *this;
}

Option& Option::any_number()
{
  option_->check(with_message(CLI::Number, "a number", ""));
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words)
{
  option_->check(with_message(CLI::IsMember(words), join_alternatives(words)));
  return *this;
}

Option& Option::shows_default()
{
  option_->capture_default_str();
  return *this;
}

Option& Option::repeatable()
{
  option_->allow_extra_args(false)->take_all();
  return *this;
}

Option& Option::takes_several()
{
  option_->expected(1, -1)->take_all();
  return *this;
}

Option& Option::takes(int n)
{
  option_->expected(n);
  return *this;
}

Option& Option::in_one_word()
{
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::separated_by_commas()
{
  option_->delimiter(',');
  return *this;
}

Option& Option::excludes(const Option& other)
{
  option_->excludes(other.option_);
  return *this;
}

Option& Option::needs(const Option& other)
{
  option_->needs(other.option_);
  return *this;
}

Option& Option::from_environment(const std::string& name)
{
  option_->envname(name);
  return *this;
}

Option& Option::named(const std::string& type)
{
  option_->type_name(type);
  return *this;
}

template <typename Value>
Option Command::option(const std::string& name, Value& value, const std::string& what)
{
  return Option(app_->add_option(name, value, what));
}

template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::vector<double>&, const std::string&);

Option Command::option_for(const std::string& name, std::function<void(const std::string&)> take,
                           const std::string& what)
{
  return Option(app_->add_option_function<std::string>(name, std::move(take), what));
}

Option Command::flag(const std::string& name, bool& value, const std::string& what)
{
  return Option(app_->add_flag(name, value, what));
}

void Command::flag_for(const std::string& name, std::function<void()> set, const std::string& what)
{
  app_->add_flag_callback(name, std::move(set), what);
}

Option Command::job(std::string& file, const std::string& what)
{
  return option("job", file, what).required();
}

Option Command::data(std::string& folder, const std::string& what)
{
  return option("--data", folder, what);
}

Option Command::overrides(std::vector<std::string>& keys)
{
  return option("--set", keys, "key=value, overrides the job file; may be repeated").repeatable();
}

Option Command::model(std::string& file, const std::string& what)
{
  return option("file", file, what).required();
}

void Command::loading(job::LoadOptions& options, const std::string& what)
{
  data(options.data_directory, what);
  overrides(options.overrides);
}

void Command::cases(job::JobSource& source, int& n_shards)
{
  job(source.job_file, "Job or campaign file (TOML)");
  loading(source);
  option("--shards", n_shards, "Shards (tasks) per case").whole_number(1, most_tasks).shows_default();
}

Option Command::threads(int& n, const std::string& what)
{
  return option("--threads", n, what).whole_number(1, 1024);
}

Option Command::progress(std::string& style)
{
  return option("--progress", style, "auto, bar, plain or none")
      .one_of({"auto", "bar", "plain", "none"})
      .shows_default();
}

Option Command::json(bool& is_json, const std::string& what)
{
  return flag("--json", is_json, what);
}

void Command::footer(const std::string& text)
{
  app_->footer(text);
}

void Command::runs(Action action)
{
  app_->callback([line = line_, action = std::move(action)] { line->chosen_ = action; });
}

bool Command::is_quiet() const
{
  return line_->is_quiet_;
}

Command Command::add(const std::string& name, const std::string& what, const std::string& example)
{
  app_->require_subcommand(1);
  return {*line_, line_->add_to(*app_, name, what, example)};
}

CommandLine::CommandLine(const ProgramText& text) : app_(std::make_unique<CLI::App>(text.what, text.name))
{
  app_->require_subcommand(1);
  app_->footer(text.footer);
  app_->set_version_flag("--version", text.version);
}

CommandLine::~CommandLine() = default;

CLI::App& CommandLine::add_to(CLI::App& parent, const std::string& name, const std::string& what,
                              const std::string& example)
{
  CLI::App& command = *parent.add_subcommand(name, what);
  command.footer("Example:\n  " + example);
  command.add_flag("-q,--quiet", is_quiet_, "Results, warnings and errors only");
  command.add_flag_callback(
      "--no-lock", [] { permit_missing_locks(core::log_warning); },
      "Go on where the file system has no locks (flock): no other process may write the same output");
  return command;
}

void CommandLine::add(const CommandRow& row)
{
  Command command(*this, add_to(*app_, row.name, row.what, row.example));
  if (row.reads_models)
    command.flag_for(
        "--unsealed", [] { store::accept_unsealed_files(); },
        "Also read files without a seal: files that another program wrote or changed");
  row.declare(command);
}

std::optional<core::ExitCode> CommandLine::parse(int argc, char** argv)
{
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& success) {
    app_->exit(success);
    std::cout.flush();
    return core::ExitCode::done;
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "%s: %s\n", app_->get_name().c_str(), usage_message(*app_, error).c_str());
    return core::ExitCode::bad_input;
  }
  return std::nullopt;
}

}  // namespace vrda::app
