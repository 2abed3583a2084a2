/// Serves the player's web page with one motion model, opens it in the default browser, and streams a bench.
#pragma once

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <utility>

namespace vrda::web {

struct WebOptions {
  std::string file;
  std::string address;          ///< numeric address to listen at; empty: 127.0.0.1
  int port = 0;                 ///< 0: any free port
  std::string certificate;      ///< PEM file; empty: plain http, or a temporary certificate
  std::string key;              ///< PEM file of its private key
  bool is_self_signed = false;  ///< make the certificate; with files: unless they exist
  bool has_qr_code = false;    ///< print the address as a QR code; always with another address than 127.0.0.1
  bool opens_browser = false;  ///< open the page in the default browser
  bool is_quiet = false;
};

/// What browsers receive of a bench.
struct LiveFeed {
  std::string greeting;               ///< first message to each browser
  std::function<std::string()> next;  ///< the present state; called in the server's thread, must not wait
  double interval_s = 1.0 / 60.0;
};

/// Listens, writes the page's address to `data` (one line) and serves until SIGINT, SIGTERM
/// or SIGHUP. The file is read for each request, so that a reload shows a new version.
/// Throws InputError for an invalid motion model, address or certificate, or a port in use.
void serve_web(const WebOptions& options, const std::optional<LiveFeed>& feed, std::ostream& data,
               std::ostream& messages);

/// Lines of half blocks (UTF-8), light modules drawn: readable on dark terminals, and by most phones on light
/// ones. Two module rows per line, with the border of four modules that ISO/IEC 18004 requires.
std::string qr_code_text(const std::string& content);

}  // namespace vrda::web
