#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace cohort::testing {

/// Passes connections to one unix socket on to another, and cuts the first few of them after some
/// bytes from the client, as a bad network does.
class CuttingRelay {
 public:
  CuttingRelay(const std::filesystem::path& from,
               const std::filesystem::path& to,
               int cuts,
               int64_t bytes_until_cut)
      : to_(to), cuts_left_(cuts), bytes_until_cut_(bytes_until_cut), listener_(Socket()) {
    const sockaddr_un address = Address(from);
    ok_ = ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
          ::listen(listener_, 16) == 0;
    acceptor_ = std::thread([this] { Accept(); });
  }
  ~CuttingRelay() {
    stopping_ = true;
    acceptor_.join();
    for (std::thread& pump : pumps_) {
      pump.join();
    }
    ::close(listener_);
  }
  CuttingRelay(const CuttingRelay&) = delete;
  CuttingRelay& operator=(const CuttingRelay&) = delete;

  [[nodiscard]] bool Ok() const { return ok_; }
  [[nodiscard]] int Cuts() const { return cuts_; }
  /// From clients, over all connections.
  [[nodiscard]] int64_t Bytes() const { return bytes_; }

 private:
  static int Socket() { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }
  static sockaddr_un Address(const std::filesystem::path& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
    return address;
  }
  static bool IsReadable(int socket) {
    pollfd waiting{.fd = socket, .events = POLLIN, .revents = 0};
    return ::poll(&waiting, 1, 20) > 0;
  }

  void Accept() {
    while (!stopping_) {
      if (!IsReadable(listener_)) {
        continue;
      }
      const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      const int server = Socket();
      const sockaddr_un address = Address(to_);
      if (::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
        ::close(client);
        ::close(server);
        continue;
      }
      pumps_.emplace_back([this, client, server] { Pump(client, server); });
    }
  }

  void Pump(int client, int server) {
    const bool is_to_be_cut = cuts_left_-- > 0;
    int64_t from_client = 0;
    std::array<char, 65536> buffer{};
    std::array<pollfd, 2> waiting = {pollfd{.fd = client, .events = POLLIN, .revents = 0},
                                     pollfd{.fd = server, .events = POLLIN, .revents = 0}};
    bool is_open = true;
    while (is_open && !stopping_) {
      ::poll(waiting.data(), waiting.size(), 20);
      for (const pollfd& ready : waiting) {
        if (ready.revents == 0) {
          continue;
        }
        const ssize_t count = ::read(ready.fd, buffer.data(), buffer.size());
        const int other = ready.fd == client ? server : client;
        is_open = is_open && count > 0 &&
                  ::send(other, buffer.data(), static_cast<size_t>(count), MSG_NOSIGNAL) == count;
        if (ready.fd == client && count > 0) {
          from_client += count;
          bytes_ += count;
        }
      }
      if (is_to_be_cut && from_client >= bytes_until_cut_) {
        ++cuts_;
        is_open = false;
      }
    }
    ::close(client);
    ::close(server);
  }

  const std::filesystem::path to_;
  std::atomic<int> cuts_left_;
  const int64_t bytes_until_cut_;
  const int listener_;
  bool ok_ = false;
  std::atomic<bool> stopping_ = false;
  std::atomic<int> cuts_ = 0;
  std::atomic<int64_t> bytes_ = 0;
  std::thread acceptor_;
  std::vector<std::thread> pumps_;  ///< Used by the acceptor until it has ended.
};

}  // namespace cohort::testing
