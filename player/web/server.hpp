/// The web page of the player, served with one motion model on this machine alone, and shown in the desktop's
/// browser.
#pragma once

#include <iosfwd>
#include <string>

namespace vrda {

struct WebOptions {
  std::string file;
  int port = 0;          ///< 0: a free one
  bool is_open = false;  ///< asks the desktop's browser to show the page
  bool is_quiet = false;
};

/// Listens on 127.0.0.1, writes the page's address to `data` (a line) and serves until SIGINT or SIGTERM.
/// The file is read anew for each request: a run that replaced it shows after a reload.
/// Throws InputError for a file that is no motion model and a port that is taken.
void serve_web(const WebOptions& options, std::ostream& data, std::ostream& talk);

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
