/// What commands print. Text is filled in from the JSON document that --json prints, so that each fact is
/// computed and named once.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/console.hpp"

namespace vrda::app {

/// Prints a document to standard output; the exit code of a command that ends with that.
core::ExitCode print_json(const nlohmann::ordered_json& json);

/// `value` by a conversion of printf, such as "%.3g"; a dash if it is not a number.
std::string formatted(const char* conversion, double value);

/// The template with each {PATH} or {PATH%CONVERSION} replaced by the value at that path of `values`: keys
/// and indices with dots between them ("grid.flexion.0"). %CONVERSION is that of printf; without one a text
/// is itself and a number an integer. A null is "none".
std::string filled(const char* text, const nlohmann::ordered_json& values);

/// Prints filled() to standard output.
void print_filled(const char* text, const nlohmann::ordered_json& values);

}  // namespace vrda::app
