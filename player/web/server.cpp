#include "web/server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <ostream>
#include <vector>

#include "core/error.hpp"
#include "store/read_apart.hpp"
#include "web/connection.hpp"
#include "web/page_file.hpp"

extern char** environ;

namespace vrda {
namespace {

/// A browser opens six at most; more wait their turn.
constexpr std::size_t most_connections = 32;
/// A connection that says and takes nothing for so long is given up.
constexpr std::chrono::seconds longest_silence{20};
constexpr int poll_ms = 1000;

InputError refused(const WebOptions& options)
{
  return InputError({"--port", "", std::to_string(options.port) + ": " + std::strerror(errno),
                     "a port from 1024 to 65535 that nothing listens on, or 0 for a free one"});
}

Descriptor listening(const WebOptions& options)
{
  Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int yes = 1;
  setsockopt(socket.number(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(options.port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto* any = reinterpret_cast<const sockaddr*>(&address);
  if (!socket.is_open() || bind(socket.number(), any, sizeof address) != 0 ||
      listen(socket.number(), 16) != 0)
    throw refused(options);
  return socket;
}

int port_of(const Descriptor& socket)
{
  sockaddr_in address{};
  socklen_t size = sizeof address;
  check(getsockname(socket.number(), reinterpret_cast<sockaddr*>(&address), &size) == 0,
        "a listening socket has a port");
  return ntohs(address.sin_port);
}

/// SIGINT and SIGTERM as something to read, for as long as it lives.
class EndSignals {
 public:
  EndSignals()
  {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    sigprocmask(SIG_BLOCK, &signals_, &before_);
    descriptor_ = Descriptor(signalfd(-1, &signals_, SFD_NONBLOCK | SFD_CLOEXEC));
    check(descriptor_.is_open(), "the end of the server can be asked for");
  }
  ~EndSignals()
  {
    // Those that came meanwhile are answered by the end itself.
    const timespec none{};
    while (sigtimedwait(&signals_, nullptr, &none) > 0) {
    }
    sigprocmask(SIG_SETMASK, &before_, nullptr);
  }
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;
  int descriptor() const { return descriptor_.number(); }

 private:
  sigset_t signals_{}, before_{};
  Descriptor descriptor_;
};

/// The model as it is now, opened where the request asks for it.
Answer answer_to(const std::optional<Request>& request, const WebOptions& options, int port)
{
  Site site;
  site.port = port;
  site.page_size = compressed_page().size();
  site.model_name = std::filesystem::path(options.file).filename().string();
  Answer answer;
  Descriptor model(open(options.file.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts {};
  if (model.is_open() && fstat(model.number(), &facts) == 0 && S_ISREG(facts.st_mode))
    site.model_size = static_cast<std::uint64_t>(facts.st_size);
  answer.response = response_to(request, site);
  if (answer.response.content == Content::model) answer.model = std::move(model);
  return answer;
}

void open_browser(const std::string& address, std::ostream& talk)
{
  std::string program = "xdg-open", argument = address;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  pid_t pid = 0;
  // The end of a child is nobody's business here.
  signal(SIGCHLD, SIG_IGN);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  if (posix_spawnp(&pid, program.c_str(), nullptr, &attributes, arguments, environ) != 0)
    talk << "no xdg-open: open " << address << " in a browser\n";
  posix_spawnattr_destroy(&attributes);
}

class Server {
 public:
  Server(const WebOptions& options, Descriptor listener)
      : options_(options), listener_(std::move(listener)), port_(port_of(listener_))
  {
  }

  int port() const { return port_; }

  void run(const EndSignals& end)
  {
    while (true) {
      std::vector<pollfd> waiting = what_to_wait_for(end);
      poll(waiting.data(), waiting.size(), poll_ms);
      if (waiting[0].revents != 0) return;
      for (std::size_t k = 0; k < connections_.size(); ++k) {
        if (waiting[k + 2].revents != 0) go_on(connections_[k]);
      }
      drop_finished();
      if (waiting[1].revents != 0) accept_one();
    }
  }

 private:
  std::vector<pollfd> what_to_wait_for(const EndSignals& end) const
  {
    const short for_new = connections_.size() < most_connections ? POLLIN : 0;
    std::vector<pollfd> waiting{{end.descriptor(), POLLIN, 0}, {listener_.number(), for_new, 0}};
    for (const Connection& connection : connections_) {
      const short wanted = connection.wants_to_write() ? POLLOUT : POLLIN;
      waiting.push_back({connection.socket(), wanted, 0});
    }
    return waiting;
  }

  void go_on(Connection& connection)
  {
    connection.go_on(
        [this](const std::optional<Request>& request) { return answer_to(request, options_, port_); });
  }

  void drop_finished()
  {
    const auto now = std::chrono::steady_clock::now();
    std::erase_if(connections_, [now](const Connection& connection) {
      return connection.is_done() || now - connection.last_moved() > longest_silence;
    });
  }

  void accept_one()
  {
    Descriptor socket(accept4(listener_.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.is_open()) connections_.emplace_back(std::move(socket));
  }

  const WebOptions& options_;
  Descriptor listener_;
  int port_;
  std::vector<Connection> connections_;
};

}  // namespace

void serve_web(const WebOptions& options, std::ostream& data, std::ostream& talk)
{
  // Says what is wrong with the file before anyone opens a page.
  read_motion_model_apart(options.file);
  const EndSignals end;
  Server server(options, listening(options));
  const std::string address = "http://127.0.0.1:" + std::to_string(server.port()) + "/";
  data << address << std::endl;
  if (!options.is_quiet)
    talk << options.file << ": open the address above in a browser; Ctrl-C ends" << std::endl;
  if (options.is_open) open_browser(address, talk);
  server.run(end);
}

}  // namespace vrda
