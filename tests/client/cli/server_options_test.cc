#include "client/cli/server_options.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace pliant::cli {
namespace {

class ServerOptionsTest : public testing::Test {
 protected:
  void SetUp() override { unsetenv("PLIANT_SERVER"); }
  void TearDown() override { unsetenv("PLIANT_SERVER"); }
};

TEST_F(ServerOptionsTest, WithoutAWordWorkIsLocal) {
  EXPECT_EQ(ServerOptions().address_if_any(), std::nullopt);
  EXPECT_EQ(ServerOptions().address(), "localhost:7447");
}

TEST_F(ServerOptionsTest, TheEnvironmentNamesAServerUnlessTheOptionsDo) {
  setenv("PLIANT_SERVER", "unix:env.sock", 1);
  EXPECT_EQ(ServerOptions().address_if_any(), "unix:env.sock");
  EXPECT_EQ(ServerOptions().address(), "unix:env.sock");
  const ServerOptions named{.server = "there:1"};
  EXPECT_EQ(named.address_if_any(), "there:1");
  EXPECT_EQ(named.address(), "there:1");
  const ServerOptions local{.server = "", .local = true};
  EXPECT_EQ(local.address_if_any(), std::nullopt);
}

TEST_F(ServerOptionsTest, LocalAndServerExcludeEachOther) {
  CLI::App app;
  ServerOptions options;
  AddServerOptions(app, options, LocalWork::kPossible);
  EXPECT_THROW(app.parse("--local --server there:1"), CLI::ParseError);
}

}  // namespace
}  // namespace pliant::cli
