// Goal: what an export is refused for, and that it does not hold up the session.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/support/files.h"
#include "tests/support/in_process_server.h"
#include "tests/support/temporary_folder.h"

namespace pliant::test {
namespace {

std::string ReasonOfExport(InProcessServer& server, const std::string& id) {
  grpc::Status status;
  EXPECT_TRUE(ExportFile(server, id, &status).empty());
  EXPECT_FALSE(status.ok());
  return ReasonOf(status);
}

class ServiceFiles : public testing::TestWithParam<bool> {
 protected:
  ServiceFiles() {
    if (GetParam()) config_.data = folder_.path();
    server_ = std::make_unique<InProcessServer>(server::RemesherFactory(), config_);
  }
  const TemporaryFolder folder_;
  server::Config config_;
  std::unique_ptr<InProcessServer> server_;
};

TEST_P(ServiceFiles, RefusesWhatHasNoRevisionOrSomethingStaged) {
  EXPECT_EQ(ReasonOfExport(*server_, "nobody"), "SESSION_NOT_FOUND");
  std::string id;
  ASSERT_TRUE(server_->Create(UnitSquare("0.1"), &id).ok());
  EXPECT_EQ(ReasonOfExport(*server_, id), "REVISION_NOT_FOUND");
  EditClient edit(*server_, id);
  edit.Advance(1);
  EXPECT_TRUE(edit.Until(1).back().has_advanced());
  const std::string first = ExportFile(*server_, id);
  edit.Size(2, "0.08");
  EXPECT_TRUE(edit.Until(2).back().has_accepted());
  EXPECT_EQ(ReasonOfExport(*server_, id), "PROTOCOL_ORDER");
  edit.Advance(3);
  EXPECT_TRUE(edit.Until(3).back().has_advanced());
  EXPECT_GT(ExportFile(*server_, id).size(), first.size()) << "a finer mesh";
}

// Goal: a file larger than one message, and with it many chunks, arrives whole.
TEST_P(ServiceFiles, SendsLargeFilesInPieces) {
  std::string id;
  ASSERT_TRUE(server_->Create(UnitSquare("0.009"), &id).ok());
  EditClient edit(*server_, id);
  edit.Advance(1);
  ASSERT_TRUE(edit.Until(1).back().has_advanced());
  const std::string file = ExportFile(*server_, id);
  EXPECT_GT(file.size(), static_cast<std::size_t>(server::kMessageBytesMax));
  v1::Session session;
  ASSERT_TRUE(ImportFile(*server_, file, "copy", &session).ok());
  EXPECT_EQ(ExportFile(*server_, "copy"), file);
}

INSTANTIATE_TEST_SUITE_P(Servers, ServiceFiles, testing::Bool(), [](const auto& with_store) {
  return with_store.param ? "WithStore" : "InMemory";
});

}  // namespace
}  // namespace pliant::test
