/// Validators of option values, and the messages of usage errors. A validator returns "" for a valid value,
/// otherwise the text "found X, wanted Y", which the program prints with the option's name and exit code 2.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
class Validator;
}  // namespace CLI

namespace vrda::app {

/// Both limits are inclusive. Message: "found "13", wanted a whole number from 1 to 12".
CLI::Validator whole_number(int least, int most);
CLI::Validator number(double least, double most, const std::vector<std::string>& words = {});  ///< or a word
CLI::Validator any_number();

/// Message: "found "stl", wanted sto, mot or csv".
CLI::Validator one_of(const std::vector<std::string>& words);

/// Options of the same meaning in every command: --set key=value of a job (repeated), --threads, --progress.
void add_overrides(CLI::App& command, std::vector<std::string>& overrides);
void add_threads(CLI::App& command, int& n_threads);
void add_progress(CLI::App& command, std::string& progress);

/// Formats a usage error of `app` as one line that ends with the matching --help command. An unknown command
/// or argument is named.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace vrda::app
