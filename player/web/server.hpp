/// Serves the player's web page with one motion model on this machine, and opens it in the default browser.
#pragma once

#include <iosfwd>
#include <string>

namespace vrda::web {

struct WebOptions {
  std::string file;
  int port = 0;                ///< 0: any free port
  bool opens_browser = false;  ///< open the page in the default browser
  bool is_quiet = false;
};

/// Listens on 127.0.0.1, writes the page's address to `data` (one line) and serves until SIGINT or SIGTERM.
/// The file is read for each request, so that a reload shows a new version.
/// Throws InputError for an invalid motion model or a port in use.
void serve_web(const WebOptions& options, std::ostream& data, std::ostream& talk);

/// Opens the browser with a private temporary file that redirects to the address, since command lines are
/// visible to all users of the machine. The destructor removes the file.
class BrowserLaunch {
 public:
  explicit BrowserLaunch(const std::string& address);
  ~BrowserLaunch();
  BrowserLaunch(const BrowserLaunch&) = delete;
  BrowserLaunch& operator=(const BrowserLaunch&) = delete;
  /// False if the file cannot be written or xdg-open is missing.
  bool is_started() const { return has_begun_; }

 private:
  std::string file_;
  bool has_begun_ = false;
};

}  // namespace vrda::web
