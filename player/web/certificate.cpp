#include "web/certificate.hpp"

#include <fcntl.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <unistd.h>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ssl/context.hpp>
#include <qrcodegen/qrcodegen.hpp>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>

#include "core/text.hpp"
#include "web/response.hpp"
#include "web/server.hpp"

namespace vrda::web {
namespace {

constexpr const char* wanted_pem = "a certificate and its private key in PEM, without a password";
/// Browsers refuse longer ones.
constexpr long valid_s = 365L * 24 * 3600;
/// Clocks of phones differ.
constexpr long valid_before_s = 24L * 3600;
constexpr std::size_t most_pem_bytes = 1U << 20U;

template <auto Free>
struct FreeWith {
  template <typename T>
  void operator()(T* object) const
  {
    Free(object);
  }
};
using Bio = std::unique_ptr<BIO, FreeWith<BIO_free>>;
using Key = std::unique_ptr<EVP_PKEY, FreeWith<EVP_PKEY_free>>;
using X509Ptr = std::unique_ptr<X509, FreeWith<X509_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, FreeWith<X509_EXTENSION_free>>;
using Names = std::unique_ptr<GENERAL_NAMES, FreeWith<GENERAL_NAMES_free>>;

/// An encrypted key is refused instead of asking for its password.
int no_password(char*, int, int, void*)
{
  return 0;
}

Bio bio_of(const std::string& text)
{
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

[[noreturn]] void refuse(const std::string& file, const std::string& found)
{
  throw InputError({"--tls", file, found, wanted_pem});
}

std::string text_of_file(const std::string& file)
{
  std::ifstream in(file, std::ios::binary);
  std::string text(most_pem_bytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || (!in.eof() && in.fail())) refuse(file, "an unreadable file");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (!in.eof()) refuse(file, "a file of more than 1 MB");
  return text;
}

std::string text_of(const GENERAL_NAME& name)
{
  const ASN1_STRING* const text = name.type == GEN_DNS ? name.d.dNSName : name.d.iPAddress;
  const unsigned char* const bytes = ASN1_STRING_get0_data(text);
  const auto n = static_cast<std::size_t>(ASN1_STRING_length(text));
  if (name.type == GEN_DNS) return {reinterpret_cast<const char*>(bytes), n};
  if (n == 4) {
    std::array<unsigned char, 4> v4{};
    std::memcpy(v4.data(), bytes, n);
    return boost::asio::ip::address_v4(v4).to_string();
  }
  if (n != 16) return {};
  std::array<unsigned char, 16> v6{};
  std::memcpy(v6.data(), bytes, n);
  return "[" + boost::asio::ip::address_v6(v6).to_string() + "]";
}

/// Without wildcards, which name no host.
std::vector<std::string> names_of(const X509& certificate)
{
  std::vector<std::string> names;
  const Names all(
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(&certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int k = 0; all && k < sk_GENERAL_NAME_num(all.get()); ++k) {
    const GENERAL_NAME& name = *sk_GENERAL_NAME_value(all.get(), k);
    if (name.type != GEN_DNS && name.type != GEN_IPADD) continue;
    const std::string text = text_of(name);
    if (!text.empty() && text.find('*') == std::string::npos) names.push_back(text);
  }
  return names;
}

std::string fingerprint_of(const X509& certificate)
{
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned n = 0;
  check(X509_digest(&certificate, EVP_sha256(), bytes.data(), &n) == 1, "OpenSSL computes a SHA-256");
  std::string text;
  for (unsigned k = 0; k < n; ++k) text += (k > 0 ? ":" : "") + hex_digits(bytes[k]);
  return text;
}

std::string warning_of(const X509& certificate, const std::string& file)
{
  if (X509_cmp_current_time(X509_get0_notAfter(&certificate)) < 0)
    return file + ": the certificate has expired: browsers warn of it";
  if (X509_cmp_current_time(X509_get0_notBefore(&certificate)) > 0)
    return file + ": the certificate is not valid yet: browsers warn of it";
  return {};
}

std::string pem_of(const std::function<int(BIO*)>& write)
{
  const Bio out(BIO_new(BIO_s_mem()));
  check(out && write(out.get()) == 1, "OpenSSL writes PEM");
  char* bytes = nullptr;
  const long n = BIO_get_mem_data(out.get(), &bytes);
  return {bytes, static_cast<std::size_t>(n)};
}

void add_extension(X509& certificate, int kind, const std::string& value)
{
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, &certificate, &certificate, nullptr, nullptr, 0);
  const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  check(extension && X509_add_ext(&certificate, extension.get(), -1) == 1, "OpenSSL adds an extension");
}

}  // namespace

Certificate read_certificate(const std::string& certificate_file, const std::string& key_file)
{
  const std::string certificate = text_of_file(certificate_file);
  return parse_certificate({certificate, text_of_file(key_file)}, certificate_file, key_file);
}

Certificate parse_certificate(const CertificateText& text, const std::string& certificate_file,
                              const std::string& key_file)
{
  const Bio in = bio_of(text.certificate);
  const X509Ptr certificate(PEM_read_bio_X509(in.get(), nullptr, no_password, nullptr));
  if (!certificate) refuse(certificate_file, "no certificate");
  const Bio key_in = bio_of(text.key);
  const Key key(PEM_read_bio_PrivateKey(key_in.get(), nullptr, no_password, nullptr));
  if (!key) {
    refuse(key_file,
           text.key.find("ENCRYPTED") != std::string::npos ? "an encrypted private key" : "no private key");
  }
  if (X509_check_private_key(certificate.get(), key.get()) != 1)
    refuse(key_file, "the key of another certificate than " + certificate_file);

  Certificate result;
  result.context = std::make_shared<boost::asio::ssl::context>(boost::asio::ssl::context::tls_server);
  SSL_CTX* const native = result.context->native_handle();
  check(SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION) == 1, "OpenSSL has TLS 1.2");
  SSL_CTX_set_options(native, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  boost::system::error_code error;
  result.context->use_certificate_chain(boost::asio::buffer(text.certificate), error);
  if (error) refuse(certificate_file, error.message());
  if (SSL_CTX_use_PrivateKey(native, key.get()) != 1) refuse(key_file, "a key that TLS cannot use");
  result.names = names_of(*certificate);
  result.fingerprint = fingerprint_of(*certificate);
  result.warning = warning_of(*certificate, certificate_file);
  return result;
}

CertificateText make_certificate(const std::string& address)
{
  const Key key(EVP_EC_gen("P-256"));
  const X509Ptr certificate(X509_new());
  check(key && certificate, "OpenSSL makes a key");
  X509_set_version(certificate.get(), X509_VERSION_3);
  // A positive random number, since browsers refuse two certificates of one issuer with the same.
  std::array<unsigned char, 8> serial{};
  check(RAND_bytes(serial.data(), static_cast<int>(serial.size())) == 1, "OpenSSL draws random bytes");
  serial[0] &= 0x7FU;
  const std::unique_ptr<BIGNUM, FreeWith<BN_free>> number(
      BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
  BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate.get()));
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -valid_before_s);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), valid_s);
  X509_set_pubkey(certificate.get(), key.get());
  X509_NAME* const name = X509_get_subject_name(certificate.get());
  constexpr std::string_view own_name = "vrda-player";
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(own_name.data()),
                             static_cast<int>(own_name.size()), -1, 0);
  X509_set_issuer_name(certificate.get(), name);
  add_extension(*certificate, NID_subject_alt_name, "IP:" + address + ",DNS:localhost,IP:127.0.0.1");
  add_extension(*certificate, NID_basic_constraints, "critical,CA:FALSE");
  add_extension(*certificate, NID_key_usage, "critical,digitalSignature");
  add_extension(*certificate, NID_ext_key_usage, "serverAuth");
  check(X509_sign(certificate.get(), key.get(), EVP_sha256()) != 0, "OpenSSL signs a certificate");
  return {pem_of([&](BIO* out) { return PEM_write_bio_X509(out, certificate.get()); }), pem_of([&](BIO* out) {
            return PEM_write_bio_PrivateKey(out, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
          })};
}

void write_certificate(const CertificateText& text, const std::string& certificate_file,
                       const std::string& key_file)
{
  constexpr mode_t readable_by_all = 0644, readable_by_owner = 0600;
  const auto write_new = [](const std::string& file, const std::string& content, mode_t mode) {
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    const bool is_written = descriptor >= 0 && ::write(descriptor, content.data(), content.size()) ==
                                                   static_cast<ssize_t>(content.size());
    const std::string reason = is_written ? "" : std::strerror(errno);
    if (descriptor >= 0) ::close(descriptor);
    if (!is_written) throw InputError({"--tls", file, reason, "a new file in a writable folder"});
  };
  write_new(key_file, text.key, readable_by_owner);
  write_new(certificate_file, text.certificate, readable_by_all);
}

// QR codes for terminals.

std::string qr_code_text(const std::string& content)
{
  constexpr int border = 4;
  const qrcodegen::QrCode code =
      qrcodegen::QrCode::encodeText(content.c_str(), qrcodegen::QrCode::Ecc::MEDIUM);
  // Modules outside are light.
  const auto is_light = [&](int x, int y) { return !code.getModule(x, y); };
  std::string text;
  for (int y = -border; y < code.getSize() + border; y += 2) {
    for (int x = -border; x < code.getSize() + border; ++x) {
      constexpr std::array blocks{" ", "\u2584", "\u2580", "\u2588"};
      text += blocks[(is_light(x, y) ? 2U : 0U) + (is_light(x, y + 1) ? 1U : 0U)];
    }
    text += '\n';
  }
  return text;
}

}  // namespace vrda::web
