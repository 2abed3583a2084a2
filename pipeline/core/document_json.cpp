// JSON text to DocumentValue.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.hpp"
#include "core/depth.hpp"
#include "core/document.hpp"

namespace vrda::inline core {
namespace {

using Json = nlohmann::json;

// Builds the tree from parser events, because nlohmann::json values lose the order of keys.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(std::string_view text, const std::string& file, const std::string& wanted)
      : text_(text), file_(file), wanted_(wanted)
  {
  }

  DocumentValue root;

  bool null() override { refuse(path(), "null", "a value"); }
  bool boolean(bool flag) override { return add({flag}); }
  bool number_integer(number_integer_t number) override { return add({std::int64_t{number}}); }
  bool number_unsigned(number_unsigned_t number) override
  {
    constexpr number_unsigned_t largest = INT64_MAX;
    return number <= largest ? add({static_cast<std::int64_t>(number)}) : add({static_cast<double>(number)});
  }
  bool number_float(number_float_t number, const std::string& /*text*/) override { return add({number}); }
  bool string(std::string& text) override { return add({text}); }
  bool binary(Json::binary_t& /*bytes*/) override { refuse("", "bytes", wanted_); }
  bool start_object(std::size_t /*n*/) override { return open({DocumentValue::Table{}}); }
  bool start_array(std::size_t /*n*/) override { return open({DocumentValue::List{}}); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& name) override
  {
    keys_.back() = name;
    return true;
  }
  bool parse_error(std::size_t byte, const std::string& /*token*/, const Json::exception& error) override
  {
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + static_cast<long>(std::min(byte, text_.size())), '\n');
    constexpr int out_of_range = 406;
    throw InputError({file_, "",
                      error.id == out_of_range ? "a number beyond the range of doubles" : "invalid JSON",
                      wanted_, static_cast<int>(line)});
  }

 private:
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file_, key, found, wanted});
  }

  // Dotted key of the current value, such as "0.dimensions".
  std::string path() const
  {
    std::string path;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const DocumentValue::List* list = open_[i].list();
      path += (path.empty() ? "" : ".") + (list == nullptr ? keys_[i] : std::to_string(list->size()));
    }
    return path;
  }

  // The last value of a repeated key is used.
  bool add(DocumentValue value)
  {
    DocumentValue& parent = open_.empty() ? root : open_.back();
    if (auto* list = std::get_if<DocumentValue::List>(&parent.data)) {
      list->push_back(std::move(value));
    } else if (DocumentValue* existing = open_.empty() ? &root : parent.find(keys_.back())) {
      *existing = std::move(value);
    } else {
      std::get<DocumentValue::Table>(parent.data).push_back({keys_.back(), std::move(value)});
    }
    return true;
  }

  bool open(DocumentValue value)
  {
    open_.push_back(std::move(value));
    keys_.emplace_back();
    return true;
  }

  bool close()
  {
    DocumentValue value = std::move(open_.back());
    open_.pop_back();
    keys_.pop_back();
    return add(std::move(value));
  }

  std::string_view text_;
  const std::string& file_;
  const std::string& wanted_;
  std::vector<DocumentValue> open_;  // unfinished lists and tables, outermost first
  std::vector<std::string> keys_;    // [open_] current key of each
};

}  // namespace

DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& wanted)
{
  require_shallow(text, file, Syntax::json);
  TreeBuilder builder(text, file, wanted);
  Json::sax_parse(text, &builder);
  return std::move(builder.root);
}

}  // namespace vrda::inline core
