#include "server/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/parse_config.h"

namespace pliant::server {
namespace {

using testing::HasSubstr;

Config Parsed(std::vector<const char*> arguments) {
  return std::get<Config>(*Parse(std::move(arguments)));
}

TEST(Config, ListensAtLoopbackByDefault) {
  EXPECT_EQ(Parsed({}).listen, "127.0.0.1:7447");
  EXPECT_EQ(Parsed({}).exposure, Exposure::kLocalOnly);
}

TEST(Config, ReadsEveryFlag) {
  const Config config =
      Parsed({"--listen", "unix:/tmp/p", "--port-file", "/tmp/port", "--workers", "3",
              "--sessions-max", "5", "--vertices-max", "1000", "--drain-ms", "7", "--log-level",
              "warning", "--log-format", "json", "--data", "none", "--insecure-any-address"});
  EXPECT_EQ(config.listen, "unix:/tmp/p");
  EXPECT_EQ(config.port_file, "/tmp/port");
  EXPECT_EQ(config.workers, 3);
  EXPECT_EQ(config.sessions_max, 5U);
  EXPECT_EQ(config.vertices_max, 1000);
  EXPECT_EQ(config.drain_ms, 7);
  EXPECT_EQ(config.log_level, LogLevel::kWarning);
  EXPECT_EQ(config.log_format, LogFormat::kJson);
  EXPECT_EQ(config.exposure, Exposure::kAnyAddress);
}

TEST(Config, RefusesAnAddressThatOthersReachUnlessAskedByName) {
  for (const char* address : {"0.0.0.0:7447", "[::]:7447", "10.0.0.1:7447", "example.org:1"}) {
    const auto refused = Parse({"--listen", address});
    ASSERT_FALSE(refused.ok()) << address;
    EXPECT_EQ(refused.error().field, "listen");
    EXPECT_THAT(refused.error().message, HasSubstr("--insecure-any-address"));
    EXPECT_TRUE(Parse({"--listen", address, "--insecure-any-address"}).ok()) << address;
  }
  for (const char* address : {"127.0.0.1:0", "127.9.9.9:1", "[::1]:0", "localhost:0", "unix:a"}) {
    EXPECT_TRUE(Parse({"--listen", address}).ok()) << address;
  }
  EXPECT_FALSE(Parse({"--listen", "localhost"}).ok()) << "no port";
}

TEST(Config, RefusesNumbersOutOfRangeAndUnknownFlags) {
  EXPECT_EQ(Parsed({"--mesh-threads", "3"}).mesh_threads, 3);
  EXPECT_EQ(Parsed({"--data", "/d", "--check-data"}).maintenance, Config::Maintenance::kCheck);
  EXPECT_EQ(Parsed({"--data", "/d", "--backup-data", "/b"}).backup, "/b");
  EXPECT_EQ(Parse({"--check-data"}).error().field, "data");
  EXPECT_EQ(Parse({"--mesh-threads", "257"}).error().field, "mesh-threads");
  EXPECT_EQ(Parse({"--mesh-threads", "-1"}).error().field, "mesh-threads");
  EXPECT_TRUE(Parse({"--workers", "256"}).ok());
  EXPECT_EQ(Parse({"--workers", "257"}).error().field, "workers");
  EXPECT_EQ(Parse({"--workers", "-1"}).error().field, "workers");
  EXPECT_EQ(Parse({"--sessions-max", "0"}).error().field, "sessions-max");
  EXPECT_EQ(Parse({"--vertices-max", "2"}).error().field, "vertices-max");
  EXPECT_EQ(Parse({"--drain-ms", "-1"}).error().field, "drain-ms");
  EXPECT_EQ(Parse({"--connection-age-max-s", "-1"}).error().field, "connection-age-max-s");
  EXPECT_EQ(Parse({"--sessions-per-tenant-max", "0"}).error().field, "sessions-per-tenant-max");
  EXPECT_EQ(Parse({"--tls-cert", "x"}).error().field, "tls-cert");
  EXPECT_EQ(Parse({"--tls-client-ca", "x"}).error().field, "tls-client-ca");
  EXPECT_EQ(Parse({"--bookmark-ms", "0"}).error().field, "bookmark-ms");
  for (const std::string key : {"tenant-vertices-max", "tenant-bytes-max", "tenant-compute-percent",
                                "tenant-compute-burst-ms", "idle-close-s"}) {
    EXPECT_TRUE(Parse({("--" + key).c_str(), "0"}).ok()) << key;
    EXPECT_EQ(Parse({("--" + key).c_str(), "-1"}).error().field, key);
  }
  EXPECT_EQ(Parse({"--sleep-after-s", "-1"}).error().field, "sleep-after-s");
  EXPECT_EQ(Parse({"--memory-limit-mib", "-1"}).error().field, "memory-limit-mib");
  EXPECT_EQ(Parsed({"--memory-limit-mib", "512"}).memory_limit_mib, 512);
  EXPECT_FALSE(Parse({"--no-such-flag"}).ok());
  EXPECT_FALSE(Parse({"--log-level", "loud"}).ok());
  EXPECT_EQ(Parsed({"--data", "here"}).data, "here");
  EXPECT_EQ(Parsed({"--data", "none"}).data, "") << "in memory only";
}

TEST(Config, ExplainsEveryFlag) {
  const auto parsed = Parse({"--help"});
  ASSERT_TRUE(parsed.ok());
  const auto& request = std::get<ExitRequest>(*parsed);
  EXPECT_EQ(request.status, 0);
  for (const char* flag : {"--config", "--listen", "--insecure-any-address", "--port-file",
                           "--workers", "--mesh-threads", "--sessions-max", "--vertices-max",
                           "--drain-ms", "--data", "--log-level", "--log-format"}) {
    EXPECT_THAT(request.text, HasSubstr(flag));
  }
  EXPECT_THAT(std::get<ExitRequest>(*Parse({"--version"})).text, HasSubstr("pliantd "));
}

TEST(Config, ReadsYamlWithTheFlagsAsKeys) {
  const auto config =
      ParseYaml("listen: unix:/x\nworkers: 3\nmesh-threads: 2\nlog-format: json\ndata: none\n", {});
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->listen, "unix:/x");
  EXPECT_EQ(config->workers, 3);
  EXPECT_EQ(config->mesh_threads, 2);
  EXPECT_EQ(config->log_format, LogFormat::kJson);
  EXPECT_TRUE(ParseYaml("", {}).ok());
  EXPECT_TRUE(ParseYaml("# nothing\n", {}).ok());
}

TEST(Config, NamesTheKeyThatIsWrongInYaml) {
  EXPECT_EQ(ParseYaml("workers: many", {}).error().field, "workers");
  EXPECT_EQ(ParseYaml("workers: many", {}).error().code, ErrorCode::kFileSyntax);
  EXPECT_EQ(ParseYaml("worker: 3", {}).error().field, "worker");
  EXPECT_EQ(ParseYaml("worker: 3", {}).error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(ParseYaml("log-level: loud", {}).error().field, "log-level");
  EXPECT_EQ(ParseYaml("- a\n- b", {}).error().code, ErrorCode::kFileSyntax);
  EXPECT_EQ(ParseYaml("a: [", {}).error().code, ErrorCode::kFileSyntax);
}

TEST(Config, LetsFlagsWinOverTheFile) {
  std::string pattern = (std::filesystem::temp_directory_path() / "pliant-XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(pattern.data());
  const std::string path = (folder / "pliantd.yaml").string();
  std::ofstream(path) << "workers: 3\nsessions-max: 9\n";
  const Config config = Parsed({"--config", path.c_str(), "--workers", "5"});
  std::filesystem::remove_all(folder);
  EXPECT_EQ(config.workers, 5);
  EXPECT_EQ(config.sessions_max, 9U);
  EXPECT_EQ(Parse({"--config", path.c_str()}).error().code, ErrorCode::kFileNotFound);
}

}  // namespace
}  // namespace pliant::server
