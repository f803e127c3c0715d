#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace pliant::client {

/// Between a client and its server: hands on what they say, until it is told to fall silent. Then
/// the connections that there are stay open and nothing comes through, as where a machine has died
/// or a firewall has forgotten them; new ones work.
class SilentProxy {
 public:
  /// @param server  "host:port" or "127.0.0.1:port" of this machine
  explicit SilentProxy(const std::string& server)
      : server_port_(static_cast<std::uint16_t>(std::stoi(server.substr(server.rfind(':') + 1)))),
        listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in any = Local(0);
    static_cast<void>(bind(listener_, reinterpret_cast<sockaddr*>(&any), sizeof(any)));
    static_cast<void>(listen(listener_, 8));
    socklen_t size = sizeof(any);
    static_cast<void>(getsockname(listener_, reinterpret_cast<sockaddr*>(&any), &size));
    address_ = "127.0.0.1:" + std::to_string(ntohs(any.sin_port));
    thread_ = std::thread([this] { Run(); });
  }
  ~SilentProxy() {
    is_over_ = true;
    thread_.join();
    close(listener_);
  }
  SilentProxy(const SilentProxy&) = delete;
  SilentProxy& operator=(const SilentProxy&) = delete;

  [[nodiscard]] const std::string& address() const { return address_; }
  void FallSilent() { falls_silent_ = true; }

 private:
  using Ends = std::pair<int, int>;

  static sockaddr_in Local(std::uint16_t port) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  void Run() {
    while (!is_over_) {
      if (falls_silent_.exchange(false)) {
        mute_.insert(mute_.end(), live_.begin(), live_.end());
        live_.clear();
      }
      std::vector<pollfd> waits{{listener_, POLLIN, 0}};
      for (const Ends& ends : live_) {
        waits.push_back({ends.first, POLLIN, 0});
        waits.push_back({ends.second, POLLIN, 0});
      }
      poll(waits.data(), waits.size(), /*timeout ms=*/10);
      if (falls_silent_) continue;
      for (std::size_t i = 1; i < waits.size(); ++i) {
        // The other end is the other one of its pair.
        if (waits[i].revents != 0) HandOn(waits[i].fd, waits[i % 2 == 1 ? i + 1 : i - 1].fd);
      }
      if (waits[0].revents != 0) Accept();
    }
    for (const auto& all : {live_, mute_}) {
      for (const Ends& ends : all) {
        close(ends.first);
        close(ends.second);
      }
    }
  }

  void Accept() {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = Local(server_port_);
    static_cast<void>(connect(server, reinterpret_cast<sockaddr*>(&address), sizeof(address)));
    live_.emplace_back(client, server);
  }

  static void HandOn(int from, int to) {
    std::array<char, 65'536> bytes;
    const ssize_t size = recv(from, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size > 0) {
      static_cast<void>(send(to, bytes.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL));
    } else if (size == 0) {
      shutdown(to, SHUT_WR);
    }
  }

  const std::uint16_t server_port_;
  const int listener_;
  std::string address_;
  std::atomic<bool> is_over_ = false;
  std::atomic<bool> falls_silent_ = false;
  std::vector<Ends> live_;
  std::vector<Ends> mute_;
  std::thread thread_;
};

}  // namespace pliant::client
