#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.hpp"
#include "documents/document.hpp"

namespace vrda {
namespace {

using Json = nlohmann::json;

// A schema has a dozen levels; many more would overflow the stack where values are copied and shown.
constexpr std::size_t deepest = 40;

// Takes the parser's events: a value of the library's own would lose the order of keys.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(std::string_view text, const std::string& file, const std::string& what)
      : text_(text), file_(file), what_(what)
  {
  }

  DocumentValue root;

  bool null() override { refuse(path(), "null", "a value"); }
  bool boolean(bool flag) override { return add({flag}); }
  bool number_integer(number_integer_t number) override { return add({std::int64_t{number}}); }
  bool number_unsigned(number_unsigned_t number) override
  {
    constexpr number_unsigned_t most = INT64_MAX;
    return number <= most ? add({static_cast<std::int64_t>(number)}) : add({static_cast<double>(number)});
  }
  bool number_float(number_float_t number, const std::string& /*text*/) override { return add({number}); }
  bool string(std::string& text) override { return add({text}); }
  bool binary(Json::binary_t& /*bytes*/) override { refuse("", "bytes", what_); }
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
                      error.id == out_of_range ? "a number beyond the range of doubles" : "no JSON", what_,
                      static_cast<int>(line)});
  }

 private:
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& wanted) const
  {
    throw InputError({file_, key, found, wanted});
  }

  // Of the value under way: "0.dimensions".
  std::string path() const
  {
    std::string path;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const DocumentValue::List* list = open_[i].list();
      path += (path.empty() ? "" : ".") + (list == nullptr ? keys_[i] : std::to_string(list->size()));
    }
    return path;
  }

  // Of a key that is there twice the last value counts.
  bool add(DocumentValue value)
  {
    DocumentValue& parent = open_.empty() ? root : open_.back();
    if (auto* list = std::get_if<DocumentValue::List>(&parent.data)) {
      list->push_back(std::move(value));
    } else if (DocumentValue* known = open_.empty() ? &root : parent.find(keys_.back())) {
      *known = std::move(value);
    } else {
      std::get<DocumentValue::Table>(parent.data).push_back({keys_.back(), std::move(value)});
    }
    return true;
  }

  bool open(DocumentValue value)
  {
    if (open_.size() == deepest) refuse("", "lists within lists within lists", what_);
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
  const std::string& what_;
  std::vector<DocumentValue> open_;  // outermost first
  std::vector<std::string> keys_;    // of each: that of the value under way
};

}  // namespace

DocumentValue parse_json(std::string_view text, const std::string& file, const std::string& what)
{
  TreeBuilder builder(text, file, what);
  Json::sax_parse(text, &builder);
  return std::move(builder.root);
}

}  // namespace vrda
