/// Table of a campaign's results with one row per case. schemas/campaign.md specifies the columns.
#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/document.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {

enum class CaseStatus : std::int8_t {
  done = 0,     ///< the motion model exists and is valid
  partial = 1,  ///< no model, but a start file or journals
  failed = 2,   ///< the model cannot be read, or its task failed
  missing = 3,  ///< no files
};

const char* name_of(CaseStatus status);

/// Times and host from <model>.run.json. They differ between runs, so they are not part of the index.
struct CaseTimes {
  std::string started;  ///< UTC
  std::string host;
  double seconds = 0.0;                    ///< wall clock
  double solving_processor_seconds = 0.0;  ///< of all threads
  int n_threads = 0;
  int n_processors = 0;
  int n_recalled = 0;  ///< steps recalled from journals
};

struct IndexRow {
  std::string name;
  std::vector<std::string> levels;  ///< [axes]
  CaseStatus status = CaseStatus::missing;
  std::string remark;  ///< reason of the failure
  // Only with a model; empty otherwise.
  std::string title, joint, side, solver;
  std::string curve;            ///< motion of the columns over flexion: "zero_varus" or "spine"
  std::vector<double> numbers;  ///< one for each of index_numbers(); NaN: no value
  std::string sha256;           ///< of the file
  std::string file;             ///< absolute
  std::optional<CaseTimes> times;
};

struct IndexNumber {
  const char* name;  ///< column of the table
  const char* units;
  const char* long_name;
};

/// The numeric columns, in order.
const std::vector<IndexNumber>& index_numbers();

/// Values of index_numbers() for `model`; `model_bytes` is the file's size.
std::vector<double> index_numbers_of(const store::MotionModel& model, double model_bytes);

/// "zero_varus" if the model has that motion, otherwise "spine" if a spine cell is stable, otherwise empty.
std::string index_curve_of(const store::MotionModel& model);

/// A case and the path of its motion model.
struct IndexedCase {
  std::string name;
  std::vector<std::string> levels;  ///< [axes]
  std::string model_path;
};

/// Reads the files of each case; one row per case. An unreadable model becomes a row, not an error. Up to
/// `n_processes` separate processes read models (store/read_separately.hpp); no other thread may use HDF5.
std::vector<IndexRow> index_rows(const std::vector<IndexedCase>& cases, int n_processes);

/// The main file of the result.
std::string index_file_of(const std::string& folder);

/// Publishes folder/index.csv and folder/index.h5, equal bytes for equal results, and folder/index.times.csv.
/// `publication`: of index_file_of(folder), locked while the rows are read. File names are written relative
/// to the folder. Throws InputError when a file cannot be written.
void publish_index(Publication& publication, const std::string& folder, const std::string& title,
                   const std::vector<std::string>& axes, const std::vector<IndexRow>& rows);

// Structs as JSON objects: `name_fields(fields, value)` lists members and keys, for both directions.

struct JsonWriter {
  nlohmann::ordered_json& json;

  template <typename Value>
  void operator()(const char* key, const Value& value) const
  {
    json[key] = value;
  }
  /// A key that is absent where the value is that of a new object.
  template <typename Value>
  void optional(const char* key, const Value& value) const
  {
    if (value != Value{}) json[key] = value;
  }
};

/// A key that is missing or has a value of another type.
struct FieldError : nlohmann::json::exception {
  FieldError(std::string key, std::string what, std::string kind)
      : nlohmann::json::exception(501, "a field"),
        field(std::move(key)),
        found(std::move(what)),
        wanted(std::move(kind))
  {
  }
  std::string field, found, wanted;
};

template <typename Value>
std::string kind_of()
{
  if constexpr (std::is_same_v<Value, std::string>) {
    return "text";
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return "a number";
  } else {
    return "a list or table";
  }
}

/// Throws FieldError.
struct JsonReader {
  const nlohmann::ordered_json& json;

  template <typename Value>
  void operator()(const char* key, Value& value) const
  {
    if (!json.contains(key)) throw FieldError(key, "nothing", kind_of<Value>());
    try {
      value = json.at(key).template get<Value>();
    } catch (FieldError& error) {
      error.field = std::string(key) + '.' + error.field;
      throw;
    } catch (const nlohmann::json::exception&) {
      throw FieldError(key, core::shown_json(json.at(key)), kind_of<Value>());
    }
  }
  template <typename Value>
  void optional(const char* key, Value& value) const
  {
    value = Value{};
    if (json.contains(key)) (*this)(key, value);
  }
};

/// The value of the file `path`. Throws InputError naming it and the field.
template <typename Value>
Value value_in(const core::JsonFile& file, const std::string& path)
{
  try {
    return file.root().get<Value>();
  } catch (const FieldError& error) {
    throw InputError({path, error.field, error.found, error.wanted});
  }
}

/// Called by the JSON library for every type with name_fields().
template <typename Value>
auto to_json(nlohmann::ordered_json& json, const Value& value)
    -> decltype(name_fields(JsonWriter{json}, const_cast<Value&>(value)))
{
  json = nlohmann::ordered_json::object();
  name_fields(JsonWriter{json}, const_cast<Value&>(value));
}

template <typename Value>
auto from_json(const nlohmann::ordered_json& json, Value& value)
    -> decltype(name_fields(JsonReader{json}, value))
{
  name_fields(JsonReader{json}, value);
}

}  // namespace vrda::run
