/// Certificates of the web server: read from PEM files, or made for one address.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace boost::asio::ssl {
class context;
}

namespace vrda::web {

struct Certificate {
  std::shared_ptr<boost::asio::ssl::context> context;  ///< TLS 1.2 or later
  std::vector<std::string> names;  ///< host names and addresses it is made out to; IPv6 in brackets
  std::string fingerprint;         ///< SHA-256 of the certificate, "AB:CD:..."
  std::string warning;             ///< expired or not yet valid; else empty
};

/// A private key and a certificate in PEM.
struct CertificateText {
  std::string certificate, key;
};

/// Throws InputError with option and file: unreadable, encrypted, not PEM, a key of another certificate.
Certificate read_certificate(const std::string& certificate_file, const std::string& key_file);

/// The same from texts; the names are used in errors.
Certificate parse_certificate(const CertificateText& text, const std::string& certificate_file,
                              const std::string& key_file);

/// A self-signed certificate (ECDSA, P-256) for a numeric address and localhost, valid for a year.
CertificateText make_certificate(const std::string& address);

/// Writes both files, the key readable by this user only. Throws InputError if one exists or cannot be
/// written.
void write_certificate(const CertificateText& text, const std::string& certificate_file,
                       const std::string& key_file);

}  // namespace vrda::web
