#include "harness/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <span>

#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, std::string_view what, int reason) {
  throw DeviceError(fmt::format("{}: {}: {}", path.string(), what, std::strerror(reason)));
}

/// Closes on every way out; close_checked() where a failure to close would lose data.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return value_; }
  bool close_checked() {
    const int descriptor = value_;
    value_ = -1;
    return ::close(descriptor) == 0;
  }

 private:
  int value_;
};

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    check(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void update(std::string_view bytes) {
    check(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1);
  }
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    check(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1);
    std::string text;
    for (const unsigned char byte : std::span(digest).first(size)) {
      text += fmt::format("{:02x}", byte);
    }
    return text;
  }

 private:
  static void check(bool good) {
    if (!good) throw DeviceError("OpenSSL: SHA-256 is not available");
  }
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

void for_each_block(const fs::path& path, const std::function<void(std::string_view)>& use) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) {
    throw InputError(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  }
  std::array<char, 1 << 16> block{};
  for (;;) {
    const ssize_t size = ::read(file.get(), block.data(), block.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EISDIR) {
      throw InputError(fmt::format("{}: is a folder; a file is expected", path.string()));
    }
    if (size < 0) fail(path, "reading failed", errno);
    if (size == 0) return;
    use({block.data(), std::size_t(size)});
  }
}

void write_and_sync(const fs::path& path, std::string_view text) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) fail(path, "cannot be created", errno);
  while (!text.empty()) {
    const ssize_t size = ::write(file.get(), text.data(), text.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) fail(path, "writing failed", errno);
    text.remove_prefix(std::size_t(size));
  }
  if (::fsync(file.get()) != 0) fail(path, "syncing failed", errno);
  if (!file.close_checked()) fail(path, "closing failed", errno);
}

}  // namespace

std::string sha256_text(std::string_view text) {
  Sha256 hash;
  hash.update(text);
  return hash.hex();
}

std::string sha256_file(const fs::path& path) {
  Sha256 hash;
  for_each_block(path, [&](std::string_view block) { hash.update(block); });
  return hash.hex();
}

std::string read_text(const fs::path& path) {
  std::string text;
  for_each_block(path, [&](std::string_view block) { text += block; });
  return text;
}

void write_text_atomically(const fs::path& path, std::string_view text) {
  static std::atomic<unsigned> counter = 0;
  const fs::path temporary = path.parent_path() / fmt::format(".{}.{}-{}", path.filename().string(),
                                                              ::getpid(), counter++);
  try {
    write_and_sync(temporary, text);
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "cannot be written", errno);
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  sync_path(path.has_parent_path() ? path.parent_path() : fs::path("."));
}

void create_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && !fs::is_directory(path, error) && !error) {
    error = std::make_error_code(std::errc::not_a_directory);
  }
  if (error) {
    throw DeviceError(
        fmt::format("{}: the folder cannot be created: {}", path.string(), error.message()));
  }
}

void sync_path(const fs::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) fail(path, "cannot be opened to sync", errno);
  // Some file systems cannot sync a folder and say EINVAL; there is nothing to wait for then.
  if (::fsync(file.get()) != 0 && errno != EINVAL) fail(path, "syncing failed", errno);
}

}  // namespace occlab
