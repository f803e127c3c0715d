#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>

namespace pliant::client {

/// A real pliantd on a Unix socket in a folder of its own, from construction to destruction.
class PliantdProcess {
 public:
  /// @param with_store  it keeps its sessions on disk, so that they outlast Kill.
  explicit PliantdProcess(bool with_store = false) {
    std::string folder = (std::filesystem::temp_directory_path() / "pliantd_XXXXXX").string();
    EXPECT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    address_ = "unix:" + folder + "/socket";
    if (with_store) {
      store_ = folder + "/data";
      std::filesystem::create_directory(store_);
    }
    Start();
  }
  ~PliantdProcess() {
    kill(process_, SIGTERM);
    int status = 0;
    waitpid(process_, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "pliantd ended with " << status;
    CloseLog();
    std::filesystem::remove_all(folder_);
  }
  PliantdProcess(const PliantdProcess&) = delete;
  PliantdProcess& operator=(const PliantdProcess&) = delete;

  [[nodiscard]] const std::string& address() const { return address_; }

  /// Ends it as a fault would.
  void Kill() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    CloseLog();
  }
  /// After Kill: at the same address.
  void Start() {
    std::array<int, 2> pipe_ends{};
    ASSERT_EQ(pipe(pipe_ends.data()), 0);
    process_ = fork();
    if (process_ == 0) {
      dup2(pipe_ends[1], STDOUT_FILENO);
      dup2(pipe_ends[1], STDERR_FILENO);
      close(pipe_ends[0]);
      close(pipe_ends[1]);
      const char* const data = store_.empty() ? nullptr : "--data";
      execl(PLIANTD_PROGRAM, PLIANTD_PROGRAM, "--listen", address_.c_str(), "--workers", "2", data,
            store_.c_str(), nullptr);
      _exit(127);
    }
    close(pipe_ends[1]);
    log_ = fdopen(pipe_ends[0], "r");
    // The line "serving" is the sign that it answers; what follows must be read, or it would wait.
    std::array<char, 1024> line{};
    bool serves = false;
    while (!serves && std::fgets(line.data(), line.size(), log_) != nullptr) {
      serves = std::string(line.data()).find(" serving ") != std::string::npos;
    }
    EXPECT_TRUE(serves) << "pliantd did not start: " << line.data();
    drain_ = std::thread([this] {
      std::array<char, 1024> rest{};
      while (std::fgets(rest.data(), rest.size(), log_) != nullptr) {
      }
    });
  }

 private:
  void CloseLog() {
    drain_.join();
    std::fclose(log_);
  }

  std::filesystem::path folder_;
  std::string address_;
  std::string store_;
  pid_t process_ = -1;
  std::FILE* log_ = nullptr;
  std::thread drain_;
};

}  // namespace pliant::client
