#include "web/session.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>

#include "core/files.hpp"

namespace vrda::web::session_test {

/// Both ends of a TCP connection of this machine.
std::pair<OpenFile, OpenFile> tcp_pair()
{
  const OpenFile listener(socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t n = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(bind(listener.get(), generic, n), 0);
  EXPECT_EQ(listen(listener.get(), 1), 0);
  EXPECT_EQ(getsockname(listener.get(), generic, &n), 0);
  OpenFile client(socket(AF_INET, SOCK_STREAM, 0));
  EXPECT_EQ(connect(client.get(), generic, n), 0);
  return {std::move(client), OpenFile(accept(listener.get(), nullptr, nullptr))};
}

/// Otherwise the last piece of an answer waits for the client's delayed acknowledgement.
TEST(WebSession, SendsWithoutDelay)
{
  boost::asio::ssl::context tls(boost::asio::ssl::context::tls_server);
  for (boost::asio::ssl::context* const used : {static_cast<boost::asio::ssl::context*>(nullptr), &tls}) {
    const auto [client, server] = tcp_pair();
    const SessionRules rules;
    boost::asio::io_context io;
    const std::shared_ptr<Session> session = start_session(io, used, dup(server.get()), rules);
    int is_set = 0;
    socklen_t n = sizeof is_set;
    ASSERT_EQ(getsockopt(server.get(), IPPROTO_TCP, TCP_NODELAY, &is_set, &n), 0);
    EXPECT_NE(is_set, 0);
    session->end();
    io.poll();
  }
}

}  // namespace vrda::web::session_test
