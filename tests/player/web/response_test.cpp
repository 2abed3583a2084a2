#include "web/response.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vrda::response_test {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const Site site{8123, 1000, "my knee é.h5", 5000};

Response asked(const std::string& target, const std::string& more = "", const std::string& method = "GET",
               const std::string& host = "127.0.0.1:8123")
{
  const std::string head = method + " " + target + " HTTP/1.1\r\nHost: " + host + more;
  return response_to(parsed_request(head), site);
}

TEST(WebRequest, ReadsWhatBrowsersSend)
{
  const auto request = parsed_request(
      "GET /model.h5?x=1 HTTP/1.1\r\nHOST:  LocalHost:80 \r\nAccept: */*\r\nRange: bytes=10-19");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->method, "GET");
  EXPECT_EQ(request->target, "/model.h5?x=1");
  EXPECT_EQ(request->host, "localhost:80");
  ASSERT_TRUE(request->range);
  EXPECT_EQ(request->range->first, 10U);
  EXPECT_EQ(request->range->last, 19U);
}

TEST(WebRequest, RefusesWhatIsNone)
{
  for (const std::string head :
       {"", "GET", "GET / HTTP/1.1", "GET / HTTP/2.0\r\nHost: a", "GET / FTP\r\nHost: a",
        " / HTTP/1.1\r\nHost: a", "GET x HTTP/1.1\r\nHost: a", "GET / HTTP/1.1\r\nHost: a\r\nHost: b",
        "GET / HTTP/1.1\r\nHost:", "GET / HTTP/1.1\r\nHost : a", "GET / HTTP/1.1\r\nHost: a\r\nno colon",
        "GET / HTTP/1.1\r\nHost: a\r\n: x", "GET /\x01 HTTP/1.1\r\nHost: a",
        "GET / HTTP/1.1\r\nHost: a\nX: b", "GET / HTTP/1.1 \r\nHost: a"}) {
    EXPECT_FALSE(parsed_request(head)) << head;
  }
  EXPECT_FALSE(parsed_request(std::string("GET / HTTP/1.1\r\nHost: a\0b", 25)));
}

TEST(WebRequest, LeavesOutARangeThatIsNone)
{
  for (const std::string range : {"bytes=", "bytes=-", "bytes=5-2", "bytes=a-b", "bytes=0-1,3-4", "lines=0-1",
                                  "bytes=5", "bytes=-1-2", "bytes=99999999999999999999-"}) {
    const auto request = parsed_request("GET / HTTP/1.1\r\nHost: a\r\nRange: " + range);
    ASSERT_TRUE(request) << range;
    EXPECT_FALSE(request->range) << range;
  }
}

TEST(WebResponse, ServesThePageAndTheModelAndNothingElse)
{
  EXPECT_EQ(asked("/").status, 302);
  EXPECT_THAT(asked("/").head, HasSubstr("Location: /?model=model.h5\r\n"));
  const Response page = asked("/?model=model.h5");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.content, Content::page);
  EXPECT_EQ(page.n_bytes, 1000U);
  EXPECT_THAT(page.head, HasSubstr("Content-Encoding: gzip\r\n"));
  const Response model = asked("/model.h5");
  EXPECT_EQ(model.content, Content::model);
  EXPECT_EQ(model.n_bytes, 5000U);
  EXPECT_THAT(model.head, HasSubstr("filename*=UTF-8''my%20knee%20%C3%A9.h5\r\n"));
  for (const std::string target : {"/../etc/passwd", "/model.h5/..", "//model.h5", "/%6dodel.h5",
                                   "/model.h5?", "/etc/passwd", "/index.html"}) {
    EXPECT_EQ(asked(target).status, 404) << target;
  }
}

TEST(WebResponse, OfARange)
{
  struct Row {
    const char* range;
    std::uint64_t first, n;
  };
  for (const Row row : {Row{"0-0", 0, 1}, Row{"10-19", 10, 10}, Row{"4990-", 4990, 10},
                        Row{"4990-9000", 4990, 10}, Row{"-10", 4990, 10}, Row{"-9000", 0, 5000}}) {
    SCOPED_TRACE(row.range);
    const Response part = asked("/model.h5", std::string("\r\nRange: bytes=") + row.range);
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.first_byte, row.first);
    EXPECT_EQ(part.n_bytes, row.n);
    EXPECT_THAT(part.head, HasSubstr("Content-Range: bytes " + std::to_string(row.first) + "-" +
                                     std::to_string(row.first + row.n - 1) + "/5000\r\n"));
  }
  for (const std::string range : {"5000-", "9000-9001", "-0"}) {
    EXPECT_EQ(asked("/model.h5", "\r\nRange: bytes=" + range).status, 416) << range;
  }
}

TEST(WebResponse, RefusesOtherHostsAndMethods)
{
  for (const std::string host : {"evil.example", "127.0.0.1", "127.0.0.1:8124", "localhost.evil.example:8123",
                                 "127.0.0.1:8123@evil.example", "[::1]:8123"}) {
    EXPECT_EQ(asked("/model.h5", "", "GET", host).status, 403) << host;
  }
  EXPECT_EQ(asked("/", "", "GET", "localhost:8123").status, 302);
  Site plain = site;
  plain.port = 80;
  for (const char* host : {"localhost", "127.0.0.1", "127.0.0.1:80"}) {
    const std::string head = std::string("GET / HTTP/1.1\r\nHost: ") + host;
    EXPECT_EQ(response_to(parsed_request(head), plain).status, 302) << host;
  }
  for (const std::string method : {"HEAD", "POST", "PUT", "DELETE", "OPTIONS", "get"}) {
    EXPECT_EQ(asked("/", "", method).status, 405) << method;
    EXPECT_THAT(asked("/", "", method).head, HasSubstr("Allow: GET\r\n"));
  }
  EXPECT_EQ(response_to(std::nullopt, site).status, 400);
}

TEST(WebResponse, WithoutAModelFile)
{
  Site gone = site;
  gone.model_size.reset();
  EXPECT_EQ(response_to(parsed_request("GET /model.h5 HTTP/1.1\r\nHost: localhost:8123"), gone).status, 404);
}

TEST(WebResponse, EveryHeadIsWhole)
{
  for (const std::string target : {"/", "/?model=model.h5", "/model.h5", "/none"}) {
    const std::string head = asked(target).head;
    EXPECT_THAT(head, StartsWith("HTTP/1.1 "));
    EXPECT_THAT(head, HasSubstr("Content-Length: " + std::to_string(asked(target).n_bytes) + "\r\n"));
    EXPECT_THAT(head, HasSubstr("X-Content-Type-Options: nosniff\r\n"));
    EXPECT_EQ(head.find("\r\n\r\n"), head.size() - 4);
  }
}

}  // namespace vrda::response_test
