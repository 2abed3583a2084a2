#include "web/response.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <set>
#include <string>

namespace vrda::web::response_test {

using testing::HasSubstr;
using testing::Not;

const std::string token = "0123456789abcdef0123456789abcdef";
const Site site{8123, token, 1000, "my knee é.h5", 5000};

Response response_for(const std::string& target, const std::string& range = "",
                      const std::string& method = "GET", const std::string& host = "127.0.0.1:8123")
{
  return response_to({method, "/" + token + target, host, range}, site);
}

std::string field_of(const Response& response, const std::string& name)
{
  for (const auto& [own, value] : response.fields) {
    if (own == name) return value;
  }
  return "none";
}

TEST(WebResponse, Targets)
{
  EXPECT_EQ(response_for("/").status, 302);
  EXPECT_EQ(field_of(response_for("/"), "Location"), "/" + token + "/?model=model.h5");
  EXPECT_EQ(response_for("").status, 302);
  const Response page = response_for("/?model=model.h5");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.content, Content::page);
  EXPECT_EQ(page.n_bytes, 1000U);
  EXPECT_EQ(field_of(page, "Content-Encoding"), "gzip");
  const Response model = response_for("/model.h5");
  EXPECT_EQ(model.content, Content::model);
  EXPECT_EQ(model.n_bytes, 5000U);
  EXPECT_EQ(field_of(model, "Content-Disposition"), "inline; filename*=UTF-8''my%20knee%20%C3%A9.h5");
  for (const std::string target : {"/../etc/passwd", "/model.h5/..", "//model.h5", "/%6dodel.h5",
                                   "/model.h5?", "/etc/passwd", "/index.html"}) {
    EXPECT_EQ(response_for(target).status, 404) << target;
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
    const Response part = response_for("/model.h5", std::string("bytes=") + row.range);
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.first_byte, row.first);
    EXPECT_EQ(part.n_bytes, row.n);
    EXPECT_EQ(field_of(part, "Content-Range"),
              "bytes " + std::to_string(row.first) + "-" + std::to_string(row.first + row.n - 1) + "/5000");
  }
  for (const std::string range : {"5000-", "9000-9001", "-0"}) {
    EXPECT_EQ(response_for("/model.h5", "bytes=" + range).status, 416) << range;
  }
}

TEST(WebResponse, IgnoredRanges)
{
  for (const std::string range : {"bytes=", "bytes=-", "bytes=5-2", "bytes=a-b", "bytes=0-1,3-4", "lines=0-1",
                                  "bytes=5", "bytes=-1-2", "bytes=99999999999999999999-"}) {
    EXPECT_EQ(response_for("/model.h5", range).status, 200) << range;
  }
}

TEST(WebResponse, HostsAndMethods)
{
  for (const std::string host : {"evil.example", "127.0.0.1", "127.0.0.1:8124", "localhost.evil.example:8123",
                                 "127.0.0.1:8123@evil.example", "[::1]:8123"}) {
    EXPECT_EQ(response_for("/model.h5", "", "GET", host).status, 403) << host;
  }
  EXPECT_EQ(response_for("/", "", "GET", "localhost:8123").status, 302);
  Site plain = site;
  plain.port = 80;
  for (const char* host : {"localhost", "127.0.0.1", "127.0.0.1:80"}) {
    EXPECT_EQ(response_to({"GET", "/" + token + "/", host, ""}, plain).status, 302) << host;
  }
  for (const std::string method : {"HEAD", "POST", "PUT", "DELETE", "OPTIONS", "get"}) {
    EXPECT_EQ(response_for("/", "", method).status, 405) << method;
    EXPECT_EQ(field_of(response_for("/", "", method), "Allow"), "GET");
  }
  EXPECT_EQ(response_for("/", "", "GET", "LOCALHOST:8123").status, 302);
  EXPECT_EQ(response_for("/", "", "GET", "").status, 400);
  EXPECT_EQ(response_to({"GET", "x", "localhost:8123", ""}, site).status, 400);
}

Site live_site()
{
  Site live = site;
  live.is_live = live.is_secure = true;
  live.hosts = {"192.168.1.20", "[fd00::7]", "knee.example"};
  return live;
}

TEST(WebResponse, WebSocketOrigin)
{
  const Site live = live_site();
  const auto status = [&](const std::string& origin, bool is_upgrade, const std::string& host) {
    return response_to({"GET", "/" + token + "/live", host, "", origin, is_upgrade}, live).status;
  };
  const std::string host = "192.168.1.20:8123";
  EXPECT_EQ(status("https://192.168.1.20:8123", true, host), 101);
  EXPECT_EQ(status("", true, host), 101);  // no browser
  EXPECT_EQ(status("", false, host), 426);
  for (const char* origin : {"http://192.168.1.20:8123", "https://192.168.1.20", "https://evil.example",
                             "null", "https://192.168.1.20:8123.evil.example", "https://192.168.1.20:8124"}) {
    EXPECT_EQ(status(origin, true, host), 403) << origin;
  }
  EXPECT_EQ(status("https://[FD00::7]:8123", true, "[fd00::7]:8123"), 101);
  EXPECT_EQ(status("https://KNEE.example:8123", true, "knee.example:8123"), 101);
  EXPECT_EQ(status("https://127.0.0.1:8123", true, "127.0.0.1:8123"), 403);
  // Without a bench the target is unknown.
  EXPECT_EQ(response_to({"GET", "/" + token + "/live", "127.0.0.1:8123", "", "", true}, site).status, 404);
  EXPECT_EQ(response_to({"POST", "/" + token + "/live", host, "", "", true}, live).status, 405);
}

TEST(WebResponse, LivePage)
{
  const Site live = live_site();
  const auto live_response = [&](const std::string& target) {
    return response_to({"GET", "/" + token + target, "knee.example:8123", ""}, live);
  };
  EXPECT_EQ(field_of(live_response("/"), "Location"), "/" + token + "/?model=model.h5&live=live");
  EXPECT_EQ(live_response("/?model=model.h5&live=live").content, Content::page);
  Site usual = live;
  usual.port = 443;
  EXPECT_EQ(response_to({"GET", "/" + token + "/", "knee.example", ""}, usual).status, 302);
  usual.port = 80;
  EXPECT_EQ(response_to({"GET", "/" + token + "/", "knee.example", ""}, usual).status, 403);
}

// Without the token nothing is revealed: the response is the same with and without a file.
TEST(WebResponse, WithoutToken)
{
  Site gone = site;
  gone.model_size.reset();
  std::string last_digit = token, first_digit = token;
  last_digit.back() = 'e';
  first_digit.front() = '1';
  for (const std::string& wrong :
       {std::string(), last_digit, first_digit, token + "0", token.substr(1), " " + token}) {
    for (const std::string target : {"", "/", "/?model=model.h5", "/model.h5", "/none", "/live"}) {
      for (const std::string method : {"GET", "POST"}) {
        SCOPED_TRACE(method + " /" + wrong + target);
        const Request request{method, "/" + wrong + target, "127.0.0.1:8123", "bytes=0-1"};
        const Response refused = response_to(request, site), without_file = response_to(request, gone);
        EXPECT_EQ(refused.status, 403);
        EXPECT_EQ(refused.content, Content::text);
        EXPECT_EQ(refused.text, without_file.text);
        EXPECT_EQ(refused.fields, without_file.fields);
        EXPECT_THAT(refused.text, Not(HasSubstr("knee")));
      }
    }
  }
  EXPECT_EQ(response_to({"GET", "/model.h5?" + token, "127.0.0.1:8123", ""}, site).status, 403);
  EXPECT_EQ(response_to({"GET", "//" + token + "/model.h5", "127.0.0.1:8123", ""}, site).status, 403);
}

TEST(WebToken, IsLongAndNeverTheSame)
{
  std::set<std::string> tokens;
  for (int k = 0; k < 1000; ++k) tokens.insert(random_token());
  EXPECT_EQ(tokens.size(), 1000U);
  EXPECT_THAT(tokens, testing::Each(testing::MatchesRegex("[0-9a-f]{32}")));
}

// The second half of the text is unreadable: a comparison that stops at the first difference never reads it;
// a constant-time one crashes here.
TEST(WebTokenDeathTest, ConstantTime)
{
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* place = mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(place, MAP_FAILED);
  char* given = static_cast<char*>(place);
  std::memset(given, 'x', 2 * page);
  ASSERT_EQ(mprotect(given + page, page, PROT_NONE), 0);
  const std::string secret(2 * page, 'a');
  EXPECT_DEATH(std::exit(is_same_token({given, 2 * page}, secret) ? 1 : 0), "");
  munmap(place, 2 * page);
}

TEST(WebResponse, EveryHeaderIsWhole)
{
  for (const Response& response :
       {response_for("/"), response_for("/?model=model.h5"), response_for("/model.h5"),
        response_for("/model.h5", "bytes=0-0"), response_for("/model.h5", "bytes=5000-"),
        response_for("/none"), response_for("", "", "GET", "evil.example"), bad_request(), request_timeout(),
        too_many_viewers()}) {
    SCOPED_TRACE(response.status);
    EXPECT_EQ(field_of(response, "Content-Length"), std::to_string(response.n_bytes));
    EXPECT_EQ(field_of(response, "Cache-Control"), "no-store");
    EXPECT_EQ(field_of(response, "X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(field_of(response, "Cross-Origin-Resource-Policy"), "same-origin");
    EXPECT_EQ(field_of(response, "Referrer-Policy"), "no-referrer");
    EXPECT_EQ(field_of(response, "Content-Security-Policy"), "frame-ancestors 'none'");
    EXPECT_EQ(field_of(response, "Connection"), "close");
    EXPECT_NE(field_of(response, "Content-Type"), "none");
  }
}

}  // namespace vrda::web::response_test
