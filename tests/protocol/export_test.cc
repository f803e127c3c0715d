// Goal: a session that goes through a file goes on with the bits of the one that stayed.
// Method: a script of updates of every kind. Before each of its advances the session is exported
// and imported on another server; both get the same updates, and diffs (metric, fields and transfer
// rows included) and answers must be equal. The servers are with and without a store in turn.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "tests/protocol/follow.h"
#include "tests/protocol/same_message.h"
#include "tests/protocol/updates.h"
#include "tests/support/files.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/temporary_folder.h"

namespace pliant::test {
namespace {

// An editor of a session that begins with the mesh that is there.
class Editor {
 public:
  Editor(InProcessServer& server, const std::string& id, const Mirror& at) : mirror(at) {
    edit_ = std::make_unique<EditClient>(
        server, id, at.revision,
        std::vector<v1::MeshPart>{v1::MESH_PART_TRANSFER, v1::MESH_PART_FIELDS,
                                  v1::MESH_PART_METRIC});
    opened = edit_->Next();
    EXPECT_TRUE(opened.has_opened()) << opened.DebugString();
  }

  v1::EditResponse Do(v1::EditRequest request, std::int64_t update_id) {
    request.set_update_id(update_id);
    edit_->Send(request);
    v1::EditResponse answer;
    for (v1::EditResponse& response : edit_->Until(update_id)) {
      if (response.has_diff()) {
        EXPECT_EQ(mirror.Apply(response.diff()), "");
        last_diff = response.diff();
      }
      if (response.has_snapshot()) {
        EXPECT_EQ(mirror.Take(response.snapshot()), "");
      }
      answer = std::move(response);
    }
    return WithoutTimes(std::move(answer));
  }

  Mirror mirror;
  v1::MeshDiff last_diff;
  v1::EditResponse opened;

 private:
  std::unique_ptr<EditClient> edit_;
};

// What comes between two advances.
using Round = std::vector<std::function<v1::EditRequest(const Mirror&)>>;

std::vector<Round> Schedule() {
  const auto size = [](const char* text) { return [text](const Mirror&) { return Size(text); }; };
  return {{size("0.05 + 0.1*x")},
          {[](const Mirror& mirror) { return Tensors(mirror, 900); },
           [](const Mirror& mirror) { return Field(mirror, 2); }},
          {[](const Mirror& mirror) { return Freeze(mirror); },
           [](const Mirror&) { return Hops(4); }, size("0.06 + 0.05*y")},
          {[](const Mirror& mirror) { return Field(mirror, 3); }, size("0.04 + 0.1*x")}};
}

struct Where {
  const char* name;
  bool from_store;
  bool to_store;
  v1::Durability durability;

  friend void PrintTo(const Where& where, std::ostream* out) { *out << where.name; }
};

class Export : public testing::TestWithParam<Where> {
 protected:
  static server::Config ConfigOf(const TemporaryFolder& folder, bool has_store) {
    server::Config config;
    if (has_store) config.data = folder.path();
    return config;
  }

  const TemporaryFolder from_folder_;
  const TemporaryFolder to_folder_;
  InProcessServer from_{server::RemesherFactory(), ConfigOf(from_folder_, GetParam().from_store)};
  InProcessServer to_{server::RemesherFactory(), ConfigOf(to_folder_, GetParam().to_store)};
};

TEST_P(Export, ASessionFromAFileGoesOnWithTheSameBits) {
  v1::CreateSession create = UnitSquare("0.1");
  create.set_session_id("s");
  create.mutable_options()->set_durability(GetParam().durability);
  ASSERT_TRUE(from_.Create(create, nullptr).ok());
  std::int64_t update_id = 1;
  Editor original(from_, "s", {});
  original.Do(Advance(), update_id);
  std::uint64_t last_hash = original.mirror.Hash();
  int number = 0;
  for (const Round& round : Schedule()) {
    SCOPED_TRACE(testing::Message() << "round " << ++number);
    const std::string id = "copy" + std::to_string(number);
    const std::string file = ExportFile(from_, "s");
    v1::Session copied;
    ASSERT_EQ(ReasonOf(ImportFile(to_, file, id, &copied)), "");
    EXPECT_EQ(copied.state_hash(), original.mirror.Hash());
    EXPECT_EQ(copied.revision(), original.mirror.revision);
    EXPECT_EQ(ExportFile(to_, id), file) << "nothing is lost on the way";
    Editor copy(to_, id, original.mirror);
    EXPECT_EQ(copy.opened.opened().last_update_id(), update_id);
    EXPECT_EQ(copy.opened.opened().staged_count(), 0);
    // Not to convergence at first: what the loop has in mind must be in the file.
    for (const std::int64_t visits : {150, 0}) {
      for (const auto& make : visits == 0 ? Round() : round) {
        const v1::EditRequest request = make(original.mirror);
        ++update_id;
        ExpectSame(original.Do(request, update_id), copy.Do(request, update_id));
      }
      ++update_id;
      ExpectSame(original.Do(Advance(visits), update_id), copy.Do(Advance(visits), update_id));
      ExpectSame(original.last_diff, copy.last_diff);
      ASSERT_TRUE(original.mirror == copy.mirror);
    }
    EXPECT_NE(original.mirror.Hash(), last_hash);
    last_hash = original.mirror.Hash();
  }
}

TEST_P(Export, SavedRevisionsAreInTheFile) {
  v1::CreateSession create = UnitSquare("0.1");
  create.set_session_id("s");
  create.mutable_options()->set_durability(GetParam().durability);
  (*create.mutable_labels())["case"] = "7";
  ASSERT_TRUE(from_.Create(create, nullptr).ok());
  Editor original(from_, "s", {});
  original.Do(Advance(), 1);
  Mirror second;
  for (int round = 1; round <= 4; ++round) {
    original.Do(Size(std::to_string(0.05 + 0.01 * round)), 2 * round);
    original.Do(Advance(), 2 * round + 1);
    if (original.mirror.revision == 2) {
      second = original.mirror;
      grpc::ClientContext context;
      v1::SaveRevisionRequest save;
      save.set_session_id("s");
      v1::SaveRevisionResponse saved;
      ASSERT_TRUE(from_.sessions->SaveRevision(&context, save, &saved).ok());
    }
  }
  v1::Session copied;
  ASSERT_TRUE(ImportFile(to_, ExportFile(from_, "s"), "copy", &copied).ok());
  ASSERT_EQ(copied.saved_revisions_size(), 1);
  EXPECT_EQ(copied.saved_revisions(0), 2);
  EXPECT_EQ(copied.labels().at("case"), "7");
  Editor copy(to_, "copy", original.mirror);
  EXPECT_TRUE(copy.Do(Rollback(3), 20).has_rejected()) << "nobody has saved it";
  for (Editor* editor : {&original, &copy}) editor->Do(Rollback(2), 21);
  EXPECT_EQ(copy.mirror.vertices, second.vertices);
  EXPECT_EQ(copy.mirror.triangles, second.triangles);
  ASSERT_TRUE(original.mirror == copy.mirror);
  for (Editor* editor : {&original, &copy}) {
    editor->Do(Size("0.07"), 22);
    editor->Do(Advance(), 23);
  }
  EXPECT_TRUE(original.mirror == copy.mirror);
}

INSTANTIATE_TEST_SUITE_P(Servers, Export,
                         testing::Values(Where{"MemoryToStore", false, true, v1::DURABILITY_NONE},
                                         Where{"StoreToMemory", true, false, v1::DURABILITY_STRICT},
                                         Where{"RelaxedToStore", true, true,
                                               v1::DURABILITY_RELAXED}),
                         [](const auto& where) { return where.param.name; });

// Goal: an imported session is durable like any other.
TEST(ExportAndImport, AnImportedSessionSurvivesItsServer) {
  const TemporaryFolder folder;
  server::Config config;
  config.data = folder.path();
  std::uint64_t hash = 0;
  {
    InProcessServer server(server::RemesherFactory(), config);
    std::string id;
    ASSERT_TRUE(server.Create(UnitSquare("0.1"), &id).ok());
    Editor editor(server, id, {});
    editor.Do(Advance(), 1);
    v1::Session copied;
    ASSERT_TRUE(ImportFile(server, ExportFile(server, id), "copy", &copied).ok());
    hash = copied.state_hash();
  }
  InProcessServer server(server::RemesherFactory(), config);
  Editor editor(server, "copy", {});
  editor.Do(Advance(), 2);
  EXPECT_EQ(editor.mirror.Hash(), hash);
  EXPECT_EQ(editor.mirror.revision, 2);
}

}  // namespace
}  // namespace pliant::test
