#include "web/connection.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "web/page_file.hpp"

namespace vrda {
namespace {

constexpr std::size_t piece_size = 65536;
/// Of what comes after the request; who sends more is cut off.
constexpr std::size_t most_drained = 1U << 20U;

bool must_wait(int error)
{
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

}  // namespace

Descriptor::~Descriptor()
{
  if (number_ >= 0) close(number_);
}

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept
{
  std::swap(number_, other.number_);
  return *this;
}

void Connection::go_on(const Answering& answering)
{
  last_moved_ = std::chrono::steady_clock::now();
  if (state_ == State::reading) read(answering);
  if (state_ == State::answering) write();
  if (state_ == State::draining) drain();
}

void Connection::read(const Answering& answering)
{
  std::array<char, 4096> piece{};
  const ssize_t n = recv(socket_.number(), piece.data(), piece.size(), 0);
  if (n < 0 && must_wait(errno)) return;
  if (n <= 0) {
    state_ = State::done;
    return;
  }
  head_.append(piece.data(), static_cast<std::size_t>(n));
  const std::size_t end = head_.find("\r\n\r\n");
  if (end == std::string::npos && head_.size() <= longest_request_head) return;
  answer_ = answering(end == std::string::npos ? std::nullopt
                                               : parsed_request(std::string_view(head_).substr(0, end)));
  pending_ = answer_.response.head + answer_.response.text;
  state_ = State::answering;
}

/// The next piece of the page or model into pending_; false at the end, and where the file has become
/// shorter.
bool Connection::fill()
{
  const Response& response = answer_.response;
  if (response.content == Content::text || n_taken_ == response.n_bytes) return false;
  const auto wanted =
      static_cast<std::size_t>(std::min<std::uint64_t>(piece_size, response.n_bytes - n_taken_));
  if (response.content == Content::page) {
    pending_ = compressed_page().substr(n_taken_, wanted);
  } else {
    pending_.resize(wanted);
    const ssize_t n = pread(answer_.model.number(), pending_.data(), wanted,
                            static_cast<off_t>(response.first_byte + n_taken_));
    if (n <= 0) return false;
    pending_.resize(static_cast<std::size_t>(n));
  }
  n_taken_ += pending_.size();
  return true;
}

void Connection::write()
{
  do {
    while (!pending_.empty()) {
      const ssize_t n = send(socket_.number(), pending_.data(), pending_.size(), MSG_NOSIGNAL);
      if (n < 0 && must_wait(errno)) return;
      if (n <= 0) {
        state_ = State::done;
        return;
      }
      pending_.erase(0, static_cast<std::size_t>(n));
    }
  } while (fill());
  shutdown(socket_.number(), SHUT_WR);
  state_ = State::draining;
}

/// Closing a socket with something unread in it would take the answer back from the other side.
void Connection::drain()
{
  std::array<char, 4096> piece{};
  ssize_t n = 0;
  while (n_drained_ <= most_drained && (n = recv(socket_.number(), piece.data(), piece.size(), 0)) > 0)
    n_drained_ += static_cast<std::size_t>(n);
  if (n == 0 || !must_wait(errno) || n_drained_ > most_drained) state_ = State::done;
}

}  // namespace vrda
