/// The desktop's browser, asked to show an address that is secret.
#pragma once

#include <string>

namespace vrda {

/// Command lines are open to all users of a machine. So the browser is given a file that only this user may
/// read, which leads to the address and is removed with this object.
class BrowserVisit {
 public:
  explicit BrowserVisit(const std::string& address);
  ~BrowserVisit();
  BrowserVisit(const BrowserVisit&) = delete;
  BrowserVisit& operator=(const BrowserVisit&) = delete;
  /// False where the file cannot be written, or there is no xdg-open.
  bool has_begun() const { return has_begun_; }

 private:
  std::string file_;
  bool has_begun_ = false;
};

}  // namespace vrda
