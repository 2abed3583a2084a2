/// What may stand on the command line, refused in our words.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
class Validator;
}  // namespace CLI

namespace vrda {

/// Both ends included. Refuses as "found "13", wanted a whole number from 1 to 12".
CLI::Validator whole_number(int least, int most);
CLI::Validator number(double least, double most);
CLI::Validator any_number();

/// Refuses as "found "stl", wanted sto, mot or csv".
CLI::Validator one_of(const std::vector<std::string>& words);

/// What was wrong with the words that `app` was given, on one line, with where help is; a command that there
/// is none of is named.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace vrda
