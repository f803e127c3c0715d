// Goal: the program itself: it tells where it listens, drains at SIGTERM, and refuses what is wrong
// with a sentence and a status.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pliant/v1/session.grpc.pb.h"
#include "tests/support/wire_arrays.h"

namespace pliant::test {
namespace {

using testing::HasSubstr;

// A pliantd with its standard error in a pipe.
class Program {
 public:
  explicit Program(std::vector<std::string> arguments) {
    int ends[2] = {};
    EXPECT_EQ(pipe(ends), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addclose(&actions, ends[1]);
    arguments.insert(arguments.begin(), PLIANTD);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    EXPECT_EQ(posix_spawn(&process_, PLIANTD, &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }
  ~Program() {
    if (process_ > 0) {
      Signal(SIGKILL);
      Wait();
    }
    fclose(output_);
  }

  /// The next line that it prints; empty at its end.
  std::string Line() {
    char text[4096] = {};
    return fgets(text, sizeof(text), output_) != nullptr ? text : "";
  }
  std::string Rest() {
    std::string rest;
    for (std::string line = Line(); !line.empty(); line = Line()) rest += line;
    return rest;
  }
  void Signal(int signal) const { kill(process_, signal); }
  /// Its exit status; -1 if a signal ended it.
  int Wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t process_ = 0;
  FILE* output_ = nullptr;
};

TEST(Pliantd, ServesUntilItIsAskedToStop) {
  std::string pattern = (std::filesystem::temp_directory_path() / "pliant-XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(pattern.data());
  const std::string port_file = (folder / "port").string();
  Program program({"--listen", "127.0.0.1:0", "--port-file", port_file, "--log-format", "json"});
  const std::string serving = program.Line();
  EXPECT_THAT(serving, HasSubstr("\"event\":\"serving\""));
  const std::string key = "\"address\":\"";
  const std::size_t begin = serving.find(key) + key.size();
  const std::string address = serving.substr(begin, serving.find('"', begin) - begin);

  const auto sessions =
      v1::SessionService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext create_context;
  v1::CreateSessionResponse response;
  const auto writer = sessions->CreateSession(&create_context, &response);
  v1::CreateSessionRequest create;
  *create.mutable_create() = UnitSquare();
  writer->Write(create);
  writer->WritesDone();
  ASSERT_TRUE(writer->Finish().ok());

  grpc::ClientContext edit_context;
  const auto edit = sessions->Edit(&edit_context);
  v1::EditRequest open;
  open.mutable_open()->set_session_id(response.session().session_id());
  edit->Write(open);
  v1::EditResponse event;
  ASSERT_TRUE(edit->Read(&event));
  EXPECT_TRUE(event.has_opened());

  program.Signal(SIGTERM);
  ASSERT_TRUE(edit->Read(&event));
  EXPECT_EQ(event.closing().error().reason(), "UNAVAILABLE");
  EXPECT_FALSE(edit->Read(&event));
  EXPECT_EQ(edit->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(program.Rest(), HasSubstr("\"event\":\"stopped\""));
  EXPECT_EQ(program.Wait(), 0);

  std::string written;
  std::getline(std::ifstream(port_file), written);
  std::filesystem::remove_all(folder);
  EXPECT_EQ(written, address);
}

TEST(Pliantd, RefusesABadFlagWithASentenceAndAStatus) {
  Program program({"--listen", "0.0.0.0:0"});
  EXPECT_THAT(program.Rest(), HasSubstr("--insecure-any-address"));
  EXPECT_EQ(program.Wait(), 2);
}

TEST(Pliantd, SaysWhenItCannotListen) {
  Program first({"--listen", "127.0.0.1:0"});
  const std::string serving = first.Line();
  const std::string key = "address=";
  const std::size_t begin = serving.find(key) + key.size();
  const std::string address = serving.substr(begin, serving.find(' ', begin) - begin);
  Program second({"--listen", address});
  EXPECT_THAT(second.Rest(), HasSubstr("pliantd: cannot listen at " + address));
  EXPECT_EQ(second.Wait(), 1);
}

TEST(Pliantd, ExplainsItself) {
  Program program({"--help"});
  EXPECT_THAT(program.Rest(), HasSubstr("--listen"));
  EXPECT_EQ(program.Wait(), 0);
}

}  // namespace
}  // namespace pliant::test
