// What durable sessions cost: JSON to standard output. tests/bench/README.md has the rows; timings
// here decide no test.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/client.h"
#include "server/saved_state.h"
#include "server/server.h"
#include "server/store/sqlite_store.h"
#include "server/stored_form.h"
#include "tests/bench/client_bench.h"
#include "tests/support/temporary_folder.h"

namespace pliant::bench {
namespace {

using client::Durability;

/// Records that one update leaves in the journal: the tensors, the commit, its answer.
constexpr double kRecordsPerUpdate = 3;

BenchServer ServerOn(const std::string& folder, int workers) {
  server::Config config;
  config.listen = "unix:" + folder + "/socket";
  config.data = folder + "/data";
  config.workers = workers;
  return BenchServer(config);
}

client::SessionSettings Settings(const std::string& id, Durability durability) {
  client::SessionSettings settings;
  settings.session_id = id;
  settings.durability = durability;
  return settings;
}

/// What a synchronisation costs by itself: a page and a half more in a file, then fdatasync.
class DiskProbe {
 public:
  explicit DiskProbe(const std::string& path) : file_(open(path.c_str(), O_CREAT | O_RDWR, 0600)) {}
  ~DiskProbe() { close(file_); }

  double Seconds() {
    const std::string bytes(6'000, static_cast<char>(size_ % 251));
    const auto begin = steady_clock::now();
    if (pwrite(file_, bytes.data(), bytes.size(), size_) < 0 || fdatasync(file_) != 0) {
      Must(Error{ErrorCode::kFileUnwritable, "the probe cannot write"});
    }
    size_ += static_cast<off_t>(bytes.size());
    return bench::Seconds(steady_clock::now() - begin);
  }

 private:
  const int file_;
  off_t size_ = 0;
};

server::StoredHead HeadOf(const std::string& folder, const std::string& id) {
  const auto store = Must(server::SqliteStore::Open({.directory = folder + "/data", .vfs = {}}));
  for (const server::StoredHead& head : Must(store->List(server::DocumentKind::kSession))) {
    if (head.key.name == id) return head;
  }
  return Must(Result<server::StoredHead>(Error{ErrorCode::kSessionNotFound, id}));
}

/// The same update of two sessions, strict and in memory only, in turns; and a probe of the disk.
json Strict(int workers, double nodes, int updates) {
  const test::TemporaryFolder folder;
  std::vector<double> strict;
  std::vector<double> none;
  std::vector<double> more;
  std::vector<double> syncs;
  json result;
  {
    const BenchServer run = ServerOn(folder.path(), workers);
    client::Client client = run.Connect();
    DiscSession durable(client, nodes, 0.01, Settings("strict", Durability::kStrict));
    DiscSession forgetful(client, nodes, 0.01, Settings("none", Durability::kNone));
    DiskProbe probe(folder.path() + "/probe");
    constexpr int kWarmUps = 4;
    for (int i = 0; i < kWarmUps + updates; ++i) {
      // Each goes first every other time.
      const double first = i % 2 == 0 ? durable.Update() : forgetful.Update();
      const double second = i % 2 == 0 ? forgetful.Update() : durable.Update();
      const double sync = probe.Seconds();
      if (i < kWarmUps) continue;
      strict.push_back(i % 2 == 0 ? first : second);
      none.push_back(i % 2 == 0 ? second : first);
      more.push_back(strict.back() - none.back());
      syncs.push_back(sync);
    }
    result["nodes"] = durable.last().summary.vertex_count;
    result["changed"] = durable.ids().size();
  }
  const server::StoredHead head = HeadOf(folder.path(), "strict");
  const auto records = static_cast<double>(head.last_number - head.snapshot_number);
  result["strict"] = Percentiles(strict);
  result["none"] = Percentiles(none);
  result["strict_costs"] = Percentiles(more);
  result["fdatasync"] = Percentiles(syncs);
  result["journal_bytes_per_update"] =
      kRecordsPerUpdate * static_cast<double>(head.journal_size) / records;
  result["updates_in_journal"] = records / kRecordsPerUpdate;
  result["snapshot_bytes"] = head.snapshot_size;
  return result;
}

/// A file's bytes, read from the system's cache.
double ReadSeconds(const std::string& path) {
  std::vector<char> buffer(1 << 20);
  std::ifstream file(path, std::ios::binary);
  const auto begin = steady_clock::now();
  while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()))) {
  }
  return Seconds(steady_clock::now() - begin);
}

/// Makes a large session with a snapshot and many small revisions since.
void MakeLarge(const std::string& folder, double nodes, int updates) {
  const double share = 100 / nodes;
  // A journal that has outgrown its input is replaced by a snapshot, at the server's end at last.
  do {
    const BenchServer run = ServerOn(folder, 2);
    client::Client client = run.Connect();
    if (Must(client.ListSessions()).empty()) {
      DiscSession made(client, nodes, share, Settings("large", Durability::kStrict));
      made.Update();
    } else {
      DiscSession(nodes, share, Must(client.OpenSession("large"))).Update();
    }
  } while (HeadOf(folder, "large").snapshot_number == 0);
  const BenchServer run = ServerOn(folder, 2);
  client::Client client = run.Connect();
  DiscSession session(nodes, share, Must(client.OpenSession("large")));
  for (int i = 0; i < updates; ++i) session.Update();
}

/// The time to bring a session back from what is stored of it, beside that of reading its bytes.
json Reopen(double nodes, int updates, int repeats) {
  const test::TemporaryFolder folder;
  MakeLarge(folder.path(), nodes, updates);
  const server::WireCodec codec;
  const server::SessionMakers makers{
      .factory = server::RemesherFactory(), .loader = server::RemesherLoader(), .codec = &codec};
  std::vector<double> file;
  std::vector<double> read;
  std::vector<double> whole;
  json result;
  for (int i = 0; i < repeats; ++i) {
    file.push_back(ReadSeconds(folder.path() + "/data/" + server::kDatabaseFile));
    const auto store =
        Must(server::SqliteStore::Open({.directory = folder.path() + "/data", .vfs = {}}));
    const server::StoreKey key = Must(store->List(server::DocumentKind::kSession)).at(0).key;
    const auto begin = steady_clock::now();
    const server::StoredDocument document = Must(store->Load(key));
    read.push_back(Seconds(steady_clock::now() - begin));
    const server::SessionMemory memory =
        Must(server::ReadMemory(document.snapshot, document.records, makers));
    whole.push_back(Seconds(steady_clock::now() - begin));
    result["nodes"] = memory.summary->vertex_count;
    result["revisions_since_snapshot"] =
        static_cast<double>(document.records.size()) / kRecordsPerUpdate;
    result["snapshot_bytes"] = document.snapshot.size();
    std::size_t journal = 0;
    for (const Bytes& record : document.records) journal += record.size();
    result["journal_bytes"] = journal;
    result["stored_bytes"] = document.head.snapshot_size + document.head.journal_size;
  }
  const auto median = [](std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
  };
  result["file_read_s"] = median(file);
  result["store_load_s"] = median(read);
  result["reopen_s"] = median(whole);
  result["ratio"] = median(whole) / median(read);
  return result;
}

// --- Many sessions ------------------------------------------------------------------------------

/// A pliantd of its own, so that its memory is its own.
class Pliantd {
 public:
  Pliantd(const std::string& program, const std::string& folder, int memory_mib, int sessions)
      : address_("unix:" + folder + "/socket") {
    std::vector<std::string> arguments = {program,
                                          "--listen",
                                          address_,
                                          "--data",
                                          folder + "/data",
                                          "--memory-limit-mib",
                                          std::to_string(memory_mib),
                                          "--sessions-max",
                                          std::to_string(sessions),
                                          "--sessions-per-tenant-max",
                                          std::to_string(sessions),
                                          "--log-level",
                                          "error"};
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawn(&process_, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0) {
      Must(Error{ErrorCode::kFileNotFound, "cannot start " + program});
    }
    // It answers a moment later.
    while (!client::Client::Connect(address_).ok()) {
      if (waitpid(process_, nullptr, WNOHANG) != 0) {
        Must(Error{ErrorCode::kUnavailable, program + " has ended"});
      }
    }
  }
  ~Pliantd() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  [[nodiscard]] client::Client Connect() const { return Must(client::Client::Connect(address_)); }
  /// "VmRSS" now, "VmHWM" at most so far, in MiB.
  [[nodiscard]] double MiB(const std::string& name) const {
    std::ifstream file("/proc/" + std::to_string(process_) + "/status");
    for (std::string word; file >> word;) {
      double kib = 0;
      if (word == name + ":" && file >> kib) return kib / 1024;
    }
    return 0;
  }

 private:
  const std::string address_;
  pid_t process_ = 0;
};

/// One visit of every session: the work by a few client threads, and the server's memory meanwhile.
json Round(const Pliantd& server, int count, int threads,
           const std::function<double(client::Client&, const std::string&)>& work) {
  std::vector<std::vector<double>> seconds(static_cast<std::size_t>(threads));
  std::vector<double> rss;
  std::atomic<int> done = 0;
  std::vector<std::thread> pool;
  const auto begin = steady_clock::now();
  for (int t = 0; t < threads; ++t) {
    pool.emplace_back([&, t] {
      client::Client client = server.Connect();
      for (int i = t; i < count; i += threads) {
        seconds[static_cast<std::size_t>(t)].push_back(work(client, "s" + std::to_string(i)));
        // One thread looks.
        if (done++; t == 0 && i % std::max(1, count / 20) < threads) {
          rss.push_back(server.MiB("VmRSS"));
        }
      }
    });
  }
  for (std::thread& thread : pool) thread.join();
  std::vector<double> all;
  for (const auto& part : seconds) all.insert(all.end(), part.begin(), part.end());
  return {{"seconds", Seconds(steady_clock::now() - begin)},
          {"one", Percentiles(all)},
          {"rss_mib", rss},
          {"rss_mib_at_most", server.MiB("VmHWM")}};
}

/// Many small sessions on a server that may not keep them all in memory: made, updated twice, each
/// time after all others, so that most of them have slept.
json Sleepers(const std::string& program, int memory_mib, int count, int threads) {
  const test::TemporaryFolder folder;
  const Pliantd server(program, folder.path(), memory_mib, count);
  json result;
  result["create"] = Round(server, count, threads, [](client::Client& client, const auto& id) {
    const auto begin = steady_clock::now();
    DiscSession session(client, 1'000, 0.05, Settings(id, Durability::kStrict));
    return Seconds(steady_clock::now() - begin);
  });
  for (const char* name : {"first_update", "second_update"}) {
    result[name] = Round(server, count, threads, [](client::Client& client, const auto& id) {
      const auto begin = steady_clock::now();
      DiscSession session(1'000, 0.05, Must(client.OpenSession(id)));
      session.Update();
      return Seconds(steady_clock::now() - begin);
    });
  }
  client::Client client = server.Connect();
  std::int64_t vertices = 0;
  int asleep = 0;
  for (const client::SessionInfo& info : Must(client.ListSessions())) {
    vertices += info.summary.vertex_count;
    if (info.state == client::SessionState::kAsleep) ++asleep;
    if (info.revision != Revision(3)) Must(Error{ErrorCode::kInternal, info.session_id});
  }
  result["sessions"] = count;
  result["vertices_mean"] = static_cast<double>(vertices) / count;
  result["asleep_at_end"] = asleep;
  result["memory_limit_mib"] = memory_mib;
  return result;
}

}  // namespace

int Main(int argc, char** argv) {
  CLI::App app("What durable sessions cost, as JSON", "store_bench");
  std::string what;
  std::string program;
  int workers = 2;
  double nodes = 0;
  int updates = 0;
  int repeats = 3;
  int count = 10'000;
  int threads = 4;
  int memory_mib = 512;
  app.add_option("what", what, "strict, reopen or sleepers")
      ->required()
      ->check(CLI::IsMember({"strict", "reopen", "sleepers"}));
  app.add_option("--workers", workers, "Of the server")->capture_default_str();
  app.add_option("--nodes", nodes, "Of the mesh; 0: 10,000, for reopen 1,000,000");
  app.add_option("--updates", updates, "Of it; 0: 200, for reopen 1,000");
  app.add_option("--repeats", repeats, "Of the reopening")->capture_default_str();
  app.add_option("--count", count, "Sessions of 1,000 nodes")->capture_default_str();
  app.add_option("--threads", threads, "Client threads")->capture_default_str();
  app.add_option("--memory-limit-mib", memory_mib, "Of pliantd")->capture_default_str();
  app.add_option("--pliantd", program, "The program, for sleepers");
  CLI11_PARSE(app, argc, argv);
  json result;
  if (what == "strict") {
    result = Strict(workers, nodes > 0 ? nodes : 1e4, updates > 0 ? updates : 200);
  } else if (what == "reopen") {
    result = Reopen(nodes > 0 ? nodes : 1e6, updates > 0 ? updates : 1'000, repeats);
  } else {
    result = Sleepers(program, memory_mib, count, threads);
  }
  result["bench"] = what;
  std::cout << result.dump(2) << '\n';
  return 0;
}

}  // namespace pliant::bench

int main(int argc, char** argv) { return pliant::bench::Main(argc, argv); }
