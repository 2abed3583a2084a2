/// A fit that refuses its marks.
#pragma once

#include <utility>
#include <vector>

#include "core/error.hpp"

namespace vrda {

class FitRefusal : public InputError {
 public:
  explicit FitRefusal(Facts facts, std::vector<std::size_t> marks = {})
      : InputError(std::move(facts)), marks_(std::move(marks))
  {
  }
  /// Those to be made again, by their place among the fit's marks; empty: the fit does not know which.
  const std::vector<std::size_t>& marks() const { return marks_; }

 private:
  std::vector<std::size_t> marks_;
};

}  // namespace vrda
