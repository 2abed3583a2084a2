// Boost.Beast, whose headers compile slowly, is included by session.cpp only.
#include "web/server.hpp"

#include <ifaddrs.h>
#include <lzma.h>
#include <stdlib.h>
#include <unistd.h>
#include <zlib.h>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <limits>
#include <ostream>
#include <string_view>
#include <vector>

#include "core/console.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "store/motion_model.hpp"
#include "web/certificate.hpp"
#include "web/response.hpp"
#include "web/session.hpp"

namespace vrda::web {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::chrono::milliseconds accept_pause{100};
/// Limits for pending requests and for responses in progress; a browser opens six connections. A request
/// whose client is suspended between connecting and sending must outlive a flood of others.
constexpr std::size_t most_pending = 128, most_answering = 32;
/// Browsers that watch a bench; their messages take 30 KB/s each.
constexpr std::size_t most_viewers = 256;

/// As in an address of a page.
std::string host_text(const asio::ip::address& address)
{
  return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
}

/// "192.168.1.20 or fd00::7"; without loopback and link-local addresses, which pages cannot name.
std::string own_addresses()
{
  std::string text;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return "an address of this machine";
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr) continue;
    asio::ip::address address;
    if (one->ifa_addr->sa_family == AF_INET) {
      const auto* const v4 = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
      address = asio::ip::address_v4(ntohl(v4->sin_addr.s_addr));
    } else if (one->ifa_addr->sa_family == AF_INET6) {
      asio::ip::address_v6::bytes_type bytes;
      const auto* const v6 = reinterpret_cast<const sockaddr_in6*>(one->ifa_addr);
      std::copy_n(v6->sin6_addr.s6_addr, bytes.size(), bytes.begin());
      address = asio::ip::address_v6(bytes);
      if (address.to_v6().is_link_local()) continue;
    } else {
      continue;
    }
    if (!address.is_loopback()) text += (text.empty() ? "" : " or ") + address.to_string();
  }
  freeifaddrs(first);
  return "a numeric address of this machine: " + (text.empty() ? "127.0.0.1" : text);
}

asio::ip::address address_of(const WebOptions& options)
{
  if (options.address.empty()) return asio::ip::address_v4::loopback();
  error_code error;
  const asio::ip::address address = asio::ip::make_address(options.address, error);
  const bool has_zone = address.is_v6() && address.to_v6().scope_id() != 0;
  if (error || address.is_unspecified() || address.is_multicast() || has_zone)
    throw InputError({"--address", "", options.address, own_addresses()});
  if (!address.is_loopback() && options.certificate.empty() && !options.is_self_signed) {
    throw InputError({"--address", "", options.address + " without TLS",
                      "--tls CERT KEY or --self-signed, since others on the network could read the token"});
  }
  return address;
}

std::optional<Certificate> certificate_of(const WebOptions& options, const asio::ip::address& address)
{
  namespace fs = std::filesystem;
  if (options.certificate.empty() && !options.is_self_signed) return std::nullopt;
  if (options.certificate.empty())
    return parse_certificate(make_certificate(address.to_string()), "the certificate", "its key");
  std::error_code ignored;
  if (options.is_self_signed && !fs::exists(options.certificate, ignored) &&
      !fs::exists(options.key, ignored))
    write_certificate(make_certificate(address.to_string()), options.certificate, options.key);
  return read_certificate(options.certificate, options.key);
}

class Server {
 public:
  Server(const WebOptions& options, const std::optional<LiveFeed>& feed) : feed_(feed)
  {
    // Before the address is printed: whoever reads it may send one at once.
    for (const int signal : stop_signals()) signals_.add(signal);
    const asio::ip::address address = address_of(options);
    certificate_ = certificate_of(options, address);
    listen(options, address);
    rules_.model = options.file;
    rules_.respond = [this](const Request& request, std::optional<std::uint64_t> size) {
      return respond(request, size);
    };
    rules_.greeting = [this] { return greeting_; };
    site_.port = acceptor_.local_endpoint().port();
    site_.is_secure = certificate_.has_value();
    site_.is_live = feed_.has_value();
    site_.token = random_token();
    site_.page_size = compressed_page().size();
    site_.model_name = std::filesystem::path(options.file).filename().string();
    host_ = host_text(address);
    if (!address.is_loopback()) site_.hosts = {host_};
    if (!certificate_) return;
    const std::vector<std::string>& names = certificate_->names;
    site_.hosts.insert(site_.hosts.end(), names.begin(), names.end());
    if (std::ranges::find(names, host_) != names.end()) return;
    // A name that the certificate is made out to, else browsers warn; another address does not lead here.
    const auto is_name = [&](const std::string& name) {
      if (name == "localhost") return address == asio::ip::address_v4::loopback();
      error_code no_address;
      asio::ip::make_address(name, no_address);
      return no_address.failed() && !name.starts_with('[');  // IPv6
    };
    const auto name = std::ranges::find_if(names, is_name);
    if (name != names.end()) {
      host_ = *name;
      return;
    }
    warning_ = options.certificate + ": names " + (names.empty() ? "no host" : names.front()) + ", not " +
               host_ + ": browsers warn";
    if (options.is_self_signed) warning_ += "; for another certificate delete it and " + options.key;
  }

  /// That the certificate is not for the address; else empty.
  const std::string& warning() const { return warning_; }

  std::string address() const { return address_for(host_); }
  std::string address_for(const std::string& host) const
  {
    return (site_.is_secure ? "https://" : "http://") + host + ":" + std::to_string(site_.port) + "/" +
           site_.token + "/";
  }
  int port() const { return site_.port; }
  const std::optional<Certificate>& certificate() const { return certificate_; }

  /// Runs until SIGINT, SIGTERM or SIGHUP.
  void run()
  {
    signals_.async_wait([this](const error_code&, int) { io_.stop(); });
    accept();
    if (feed_) {
      greeting_ = std::make_shared<const std::string>(feed_->greeting);
      tick_.expires_after(std::chrono::seconds(0));
      stream();
    }
    io_.run();
  }

 private:
  void listen(const WebOptions& options, const asio::ip::address& address)
  {
    const tcp::endpoint endpoint(address, static_cast<std::uint16_t>(options.port));
    error_code error;
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(tcp::acceptor::max_listen_connections, error);
    if (error == asio::error::address_family_not_supported ||
        error == error_code(EADDRNOTAVAIL, boost::system::system_category()))
      throw InputError({"--address", "", options.address + ": " + error.message(), own_addresses()});
    if (error)
      throw InputError({"--port", "", std::to_string(options.port) + ": " + error.message(),
                        "an unused port from 1024 to 65535, or 0 for any free port"});
  }

  void accept()
  {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (error) return accept_later();
      make_room(SessionKind::pending);
      const int handle = socket.release(error);
      if (error) return accept_later();
      asio::ssl::context* const tls = certificate_ ? certificate_->context.get() : nullptr;
      sessions_.push_back(start_session(io_, tls, handle, rules_));
      accept();
    });
  }

  /// Retries after a pause if no file descriptor is available.
  void accept_later()
  {
    pause_.expires_after(accept_pause);
    pause_.async_wait([this](const error_code&) { accept(); });
  }

  Response respond(const Request& request, std::optional<std::uint64_t> model_size)
  {
    Site site = site_;
    site.model_size = model_size;
    Response response = response_to(request, site);
    // Text responses are short and do not count towards the limit.
    if (response.content == Content::page || response.content == Content::model)
      make_room(SessionKind::answering);
    if (response.content == Content::live && sessions_of(SessionKind::live).size() >= most_viewers)
      return too_many_viewers();
    return response;
  }

  std::vector<std::shared_ptr<Session>> sessions_of(SessionKind kind)
  {
    std::vector<std::shared_ptr<Session>> found;
    std::erase_if(sessions_, [&](const std::weak_ptr<Session>& one) {
      const std::shared_ptr<Session> session = one.lock();
      if (!session || session->kind() == SessionKind::ended) return true;
      if (session->kind() == kind) found.push_back(session);
      return false;
    });
    return found;
  }

  /// Makes room for one more session of a kind: at the limit ends the session idle for the longest time.
  void make_room(SessionKind kind)
  {
    const std::vector<std::shared_ptr<Session>> rivals = sessions_of(kind);
    if (rivals.size() < (kind == SessionKind::pending ? most_pending : most_answering)) return;
    const auto since = [](const auto& session) { return session->waits_since(); };
    (*std::ranges::min_element(rivals, {}, since))->end();
  }

  /// Reads the bench at its rate, with or without viewers, and sends its state to all of them.
  void stream()
  {
    tick_.async_wait([this](const error_code&) {
      const auto interval = std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(feed_->interval_s));
      // Ticks missed during a delay are skipped.
      tick_.expires_at(std::max(tick_.expiry() + interval, asio::steady_timer::clock_type::now()));
      const auto message = std::make_shared<const std::string>(feed_->next());
      for (const std::shared_ptr<Session>& session : sessions_of(SessionKind::live)) session->offer(message);
      stream();
    });
  }

  std::optional<LiveFeed> feed_;
  std::optional<Certificate> certificate_;
  Site site_;
  std::string host_, warning_;
  SessionRules rules_;
  LiveMessage greeting_;
  std::vector<std::weak_ptr<Session>> sessions_;
  asio::io_context io_{1};
  asio::signal_set signals_{io_};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer pause_{io_}, tick_{io_};
};

/// How to reach the page, besides its address.
void write_ways(const WebOptions& options, const Server& server, std::ostream& messages)
{
  messages << options.file << ": open the address above in a browser; Ctrl-C quits\n";
  const std::optional<Certificate>& certificate = server.certificate();
  if (certificate && !certificate->warning.empty()) messages << certificate->warning << "\n";
  if (!server.warning().empty()) messages << server.warning() << "\n";
  if (certificate && options.is_self_signed)
    messages << "The certificate is self-signed: accept the browser's warning if its SHA-256 fingerprint is\n"
             << certificate->fingerprint << "\n";
  const bool is_for_usb = !certificate && options.has_qr_code;
  if (is_for_usb)
    messages << "On an Android phone by USB, first: adb reverse tcp:" << server.port()
             << " tcp:" << server.port() << "\n";
  const bool is_on_network = !options.address.empty() && certificate;
  if (options.has_qr_code || is_on_network)
    messages << qr_code_text(is_for_usb ? server.address_for("localhost") : server.address());
  messages << std::flush;
}

/// Opens the default browser with a private temporary file that redirects to the address, since command lines
/// are visible to all users of the machine. The destructor removes the file.
class BrowserLaunch {
 public:
  explicit BrowserLaunch(const std::string& address)
  {
    constexpr std::string_view ending = ".html";
    std::error_code error;
    file_ =
        (std::filesystem::temp_directory_path(error) / "vrda-player-XXXXXX").string() + std::string(ending);
    const int descriptor = mkstemps(file_.data(), static_cast<int>(ending.size()));
    if (descriptor < 0) {
      file_.clear();
      return;
    }
    const std::string page =
        "<!DOCTYPE html><meta charset=\"utf-8\"><title>VRDA player</title>"
        "<meta http-equiv=\"refresh\" content=\"0; url=" +
        address + "\">\n";
    const bool is_written = write(descriptor, page.data(), page.size()) == static_cast<ssize_t>(page.size());
    if (close(descriptor) != 0 || !is_written) return;
    is_started_ =
        start_process({"xdg-open", file_}, {.in = STDIN_FILENO, .out = STDOUT_FILENO, .err = STDERR_FILENO})
            .error == 0;
  }
  ~BrowserLaunch() { unlink(file_.c_str()); }
  BrowserLaunch(const BrowserLaunch&) = delete;
  BrowserLaunch& operator=(const BrowserLaunch&) = delete;

  /// False if the file cannot be written or xdg-open is missing.
  bool is_started() const { return is_started_; }

 private:
  std::string file_;
  bool is_started_ = false;
};

}  // namespace

void serve_web(const WebOptions& options, const std::optional<LiveFeed>& feed, std::ostream& data,
               std::ostream& messages)
{
  // Reports an invalid file before the page is opened.
  store::require_grid(store::read_motion_model(options.file), options.file, "vrda-player web");
  Server server(options, feed);
  const std::string address = server.address();
  data << address << std::endl;
  if (!options.is_quiet) write_ways(options, server, messages);
  std::optional<BrowserLaunch> visit;
  if (options.opens_browser) visit.emplace(address);
  if (visit && !visit->is_started()) messages << "no browser found: open " << address << std::endl;
  server.run();
}

// The page is embedded as xz, which is a quarter smaller than gzip; browsers accept gzip.

namespace {

std::string unpacked(std::string_view xz)
{
  std::string text;
  constexpr std::size_t piece = 1U << 20U;
  lzma_stream stream = LZMA_STREAM_INIT;
  lzma_ret state = lzma_stream_decoder(&stream, std::numeric_limits<std::uint64_t>::max(), 0);
  stream.next_in = reinterpret_cast<const std::uint8_t*>(xz.data());
  stream.avail_in = xz.size();
  while (state == LZMA_OK) {
    const std::size_t n = text.size();
    text.resize(n + piece);
    stream.next_out = reinterpret_cast<std::uint8_t*>(text.data() + n);
    stream.avail_out = piece;
    state = lzma_code(&stream, LZMA_FINISH);
    text.resize(n + piece - stream.avail_out);
  }
  lzma_end(&stream);
  check(state == LZMA_STREAM_END, "the embedded page can be unpacked");
  return text;
}

std::string gzipped(const std::string& text)
{
  constexpr int level = 6, gzip_window_bits = 15 + 16, usual_memory = 8;
  z_stream stream{};
  check(deflateInit2(&stream, level, Z_DEFLATED, gzip_window_bits, usual_memory, Z_DEFAULT_STRATEGY) == Z_OK,
        "zlib starts");
  std::string packed(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib only reads
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int state = deflate(&stream, Z_FINISH);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  check(state == Z_STREAM_END, "the page fits its bound");
  return packed;
}

}  // namespace

std::string_view compressed_page()
{
  static const std::string page = gzipped(unpacked(embedded_page()));
  return page;
}

}  // namespace vrda::web
