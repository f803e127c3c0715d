#include "client/cli/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/file.h"
#include "tests/client/cli/support.h"

namespace pliant::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> Keys(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

// Goal: programs can rely on the names in the report.
TEST(Report, TheReportHasTheDocumentedFields) {
  RemeshResult result;
  result.report.summary = {
      .vertex_count = 4, .triangle_count = 2, .edge_count = 5, .state_hash = 0xabc};
  result.report.visits = 9;
  const RemeshReport report{.input = "a.poly",
                            .output = "b.vtu",
                            .server = std::nullopt,
                            .read_seconds = 0.5,
                            .remesh_seconds = 0.25,
                            .write_seconds = 0.125,
                            .peak_memory_bytes = 1024};
  const Json json = RemeshJson(report, result);
  EXPECT_THAT(Keys(json), ElementsAre("pliant_version", "mode", "input", "output", "vertex_count",
                                      "triangle_count", "constrained_edge_count", "state_hash",
                                      "stop", "active_count", "seconds", "peak_memory_bytes",
                                      "loop", "limits", "troubles", "quality"));
  EXPECT_TRUE(json["limits"].is_null()) << "nothing limited the metric";
  EXPECT_EQ(json["mode"], "local");
  EXPECT_EQ(json["vertex_count"], 4);
  EXPECT_EQ(json["state_hash"], "0000000000000abc") << "16 digits: JSON has no 64-bit numbers";
  EXPECT_EQ(json["stop"], "converged");
  EXPECT_THAT(Keys(json["seconds"]), ElementsAre("read", "remesh", "write"));
  EXPECT_EQ(json["seconds"]["remesh"], 0.25);
  EXPECT_EQ(json["loop"]["visits"], 9);
  EXPECT_EQ(json["quality"]["angles_deg"]["counts"].size(), 60U);
  EXPECT_EQ(json["quality"]["lengths"]["high"], 2.0);
  EXPECT_THAT(Keys(json["quality"]["integrated"]),
              ElementsAre("mean", "min", "max", "share_sqrt2", "share_125"));

  RemeshReport remote = report;
  remote.server = "unix:s.sock";
  EXPECT_EQ(RemeshJson(remote, result)["mode"], "server");
  EXPECT_EQ(RemeshJson(remote, result)["server"], "unix:s.sock");
}

TEST(Report, SessionsHaveTimesInUtc) {
  client::SessionInfo session;
  session.session_id = "wing";
  session.revision = Revision{7};
  session.create_time = std::chrono::system_clock::time_point(std::chrono::seconds(1'700'000'000));
  const Json json = SessionJson(session);
  EXPECT_EQ(json["session_id"], "wing");
  EXPECT_EQ(json["revision"], 7);
  EXPECT_EQ(json["create_time"], "2023-11-14T22:13:20Z");
}

TEST(Report, EarlyEndsAreExplained) {
  client::AdvanceReport report;
  EXPECT_THAT(StopWarning(report), IsEmpty());
  report.active_count = 1234;
  for (const auto stop : {client::AdvanceStop::kVisitBudget, client::AdvanceStop::kTimeBudget,
                          client::AdvanceStop::kCancelled, client::AdvanceStop::kVisitLimit,
                          client::AdvanceStop::kServerClosing}) {
    report.stop = stop;
    EXPECT_THAT(StopWarning(report), HasSubstr("1,234 vertices")) << StopName(stop);
  }
  report.stop = client::AdvanceStop::kStaging;
  EXPECT_THAT(StopWarning(report), HasSubstr("nothing was committed"));
  report.stop = client::AdvanceStop::kVertexLimit;
  EXPECT_THAT(StopWarning(report), HasSubstr("--vertices-max"));
}

TEST(Report, TroublesAreNamedCountedAndPlaced) {
  RemeshResult result;
  EXPECT_THAT(TroubleWarning(result.report), IsEmpty());
  EXPECT_THAT(RemeshJson({}, result)["troubles"], IsEmpty());
  result.report.troubles = {{.kind = TroubleKind::kSizeJump,
                             .vertex_count = 1200,
                             .place_count = 2,
                             .center = {0.25, -8},
                             .box = {{0, -9}, {1, -7}},
                             .q_min = 0.125,
                             .length_min = 0.5,
                             .length_max = 3},
                            {.kind = TroubleKind::kGeometry, .vertex_count = 34}};
  const std::string text = TroubleWarning(result.report);
  EXPECT_THAT(text, HasSubstr("3 places, 1,234 vertices"));
  EXPECT_THAT(text, HasSubstr("size_jump"));
  EXPECT_THAT(text, HasSubstr("near (0.25, -8), lengths 0.5 to 3, quality 0.125"));
  const Json json = RemeshJson({}, result)["troubles"];
  EXPECT_EQ(json[0]["kind"], "size_jump");
  EXPECT_EQ(json[0]["box"], Json({0.0, -9.0, 1.0, -7.0}));
  EXPECT_EQ(json[1]["kind"], "geometry");
  EXPECT_EQ(json[1]["vertex_count"], 34);
}

TEST(Report, TroublesComeWithWhatMayHelp) {
  client::AdvanceReport report;
  report.troubles = {{.kind = TroubleKind::kCrossed}};
  EXPECT_THAT(TroubleWarning(report), HasSubstr("--hgrad 1.5 --rotation 0.7"));
  EXPECT_THAT(TroubleWarning(report), Not(HasSubstr("--geometry")));
  report.metric.limits = true;
  EXPECT_THAT(TroubleWarning(report), Not(HasSubstr("--hgrad"))) << "they did not help";
  report.troubles = {{.kind = TroubleKind::kGeometry}};
  EXPECT_THAT(TroubleWarning(report), HasSubstr("--geometry 1"));
}

TEST(Report, LimitsThatNobodyAskedForAreTold) {
  client::AdvanceReport report;
  EXPECT_THAT(LimitsNote({}, report), IsEmpty());
  report.metric.limits = true;
  report.metric.gradation_count = 7;
  report.metric.raw_complexity = 100;
  report.metric.limited_complexity = 125;
  EXPECT_THAT(LimitsNote({}, report), HasSubstr("1.25 times as many vertices; --hgrad 0"));
  EXPECT_THAT(LimitsNote({.gradation = 2}, report), IsEmpty());
  EXPECT_THAT(LimitsNote({.automatic = false}, report), IsEmpty());
  const Json json = AdvanceJson(report)["limits"];
  EXPECT_EQ(json["gradation_count"], 7);
  EXPECT_EQ(json["complexity_before"], 100);
  EXPECT_EQ(json["complexity_after"], 125);
}

TEST(Report, TextForPeopleHasEveryMeasure) {
  Quality quality;
  quality.vertex_count = 12345;
  quality.q_min = 0.25;
  quality.complexity = 42;
  const std::string text = QualityText(quality);
  EXPECT_THAT(text, HasSubstr("12,345"));
  EXPECT_THAT(text, HasSubstr("0.2500 least"));
  EXPECT_THAT(text, HasSubstr("42\n"));
}

TEST(Report, MemoryIsThatOfThisProcess) {
  const std::int64_t before = PeakMemoryBytes();
  EXPECT_GT(before, 1'000'000);
  // More than all that was ever in use, some of which may be free again.
  const std::vector<char> block(static_cast<std::size_t>(before) + 50'000'000, 1);
  EXPECT_GE(PeakMemoryBytes(), before + 50'000'000 - static_cast<std::int64_t>(block[0]));
}

TEST(Report, WritesToAFile) {
  const TestFolder folder;
  ASSERT_TRUE(WriteJson(folder.Path("r.json"), {{"a", 0.1}}).ok());
  EXPECT_EQ(Json::parse(io::ReadFile(folder.Path("r.json")).value())["a"], 0.1);
  EXPECT_FALSE(WriteJson(folder.Path("none/r.json"), {}).ok());
}

}  // namespace
}  // namespace pliant::cli
