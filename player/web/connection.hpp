/// One connection of the web server, driven by what its socket is ready for.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "web/response.hpp"

namespace vrda {

/// Closes its descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }

 private:
  int number_;
};

struct Answer {
  Response response;
  Descriptor model;  ///< open where the response sends the model
};

/// Reads one request, sends one answer, waits for the other side to close. Never blocks.
class Connection {
 public:
  using Answering = std::function<Answer(const std::optional<Request>&)>;
  explicit Connection(Descriptor socket) : socket_(std::move(socket)) {}

  int socket() const { return socket_.number(); }
  bool wants_to_write() const { return state_ == State::answering; }
  bool is_done() const { return state_ == State::done; }
  std::chrono::steady_clock::time_point last_moved() const { return last_moved_; }
  /// Goes on as far as the socket lets it.
  void go_on(const Answering& answering);

 private:
  enum class State { reading, answering, draining, done };
  void read(const Answering& answering);
  void write();
  void drain();
  bool fill();

  Descriptor socket_;
  std::string head_;  ///< of the request, as far as it came
  Answer answer_;
  std::string pending_;        ///< of the answer, to be sent next
  std::uint64_t n_taken_ = 0;  ///< bytes of the page or model that went into pending_
  std::size_t n_drained_ = 0;  ///< bytes that came after the request
  State state_ = State::reading;
  std::chrono::steady_clock::time_point last_moved_ = std::chrono::steady_clock::now();
};

}  // namespace vrda
