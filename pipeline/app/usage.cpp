#include "app/usage.hpp"

#include <CLI/CLI.hpp>

#include "core/text.hpp"

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

}  // namespace

CLI::Validator whole_number(int least, int most)
{
  return with_message(CLI::Range(least, most),
                      "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

CLI::Validator number(double least, double most, const std::vector<std::string>& words)
{
  const std::string range = "a number from " + shortest_decimal(least) + " to " + shortest_decimal(most);
  if (words.empty()) return with_message(CLI::Range(least, most), range);
  std::vector<std::string> alternatives = words;
  alternatives.push_back(range);
  return with_message(CLI::Validator(CLI::IsMember(words)) | CLI::Range(least, most),
                      join_alternatives(alternatives));
}

CLI::Validator any_number()
{
  return with_message(CLI::Number, "a number", "");
}

CLI::Validator one_of(const std::vector<std::string>& words)
{
  return with_message(CLI::IsMember(words), join_alternatives(words));
}

void add_overrides(CLI::App& command, std::vector<std::string>& overrides)
{
  command.add_option("--set", overrides, "key=value, overrides the job file; may be repeated")
      ->allow_extra_args(false)
      ->take_all();
}

void add_threads(CLI::App& command, int& n_threads)
{
  command.add_option("--threads", n_threads, "Worker threads; default: one per processor")
      ->check(whole_number(1, 1024));
}

void add_progress(CLI::App& command, std::string& progress)
{
  command.add_option("--progress", progress, "auto, bar, plain or none")
      ->check(one_of({"auto", "bar", "plain", "none"}))
      ->capture_default_str();
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

}  // namespace vrda::app
