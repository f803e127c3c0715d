#include "client/io/sol.h"

#include <gtest/gtest.h>

#include "client/io/formats.h"
#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

PointField RandomField(std::int32_t component_count, std::uint64_t seed) {
  Rng rng(seed);
  PointField field;
  field.component_count = component_count;
  for (int i = 0; i < 30 * component_count; ++i) field.values.push_back(rng.Uniform(1e-9, 3));
  return field;
}

ErrorCode CodeOf(const Result<PointField>& result) {
  return result.ok() ? ErrorCode::kInternal : result.error().code;
}

TEST(Sol, RoundTripsToTheBit) {
  for (const std::int32_t component_count : {1, 3}) {
    const PointField field = RandomField(component_count, 8);
    const Result<PointField> read = ParseSol(FormatSol(field));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(*read, field);
  }
}

TEST(Sol, KeepsTheOrderOfTensorEntries) {
  const Result<PointField> plane =
      ParseSol("MeshVersionFormatted 2 Dimension 2 SolAtVertices 1 1 3 11 12 22 End");
  EXPECT_EQ(plane.value().values, (std::vector<double>{11, 12, 22}));
  const Result<PointField> space =
      ParseSol("MeshVersionFormatted 2 Dimension 3 SolAtVertices 1 1 3 11 12 22 13 23 33 End");
  EXPECT_EQ(space.value().values, (std::vector<double>{11, 12, 22}));
  const Result<PointField> bamg = ParseMtr("2 3\n11 12 22\n4 0 5\n");
  EXPECT_EQ(bamg.value().values, (std::vector<double>{11, 12, 22, 4, 0, 5}));
  EXPECT_EQ(ParseMtr("2 1 0.5 0.25").value().values, (std::vector<double>{0.5, 0.25}));
}

TEST(Sol, RefusesWhatIsNoMetric) {
  const std::string head = "MeshVersionFormatted 2 Dimension 2 ";
  EXPECT_EQ(CodeOf(ParseSol(head + "SolAtVertices 1 1 2 5 6")), ErrorCode::kFileUnsupported);
  EXPECT_EQ(CodeOf(ParseSol(head + "SolAtVertices 1 2 1 1 5 6")), ErrorCode::kFileUnsupported);
  EXPECT_EQ(CodeOf(ParseSol(head + "SolAtVertices 99 1 1 5 6")), ErrorCode::kFileSyntax);
  EXPECT_EQ(CodeOf(ParseSol(head + "End")), ErrorCode::kEmpty);
  EXPECT_EQ(CodeOf(ParseMtr("2 2 1 1 1 1")), ErrorCode::kFileSyntax);
  EXPECT_EQ(CodeOf(ParseMtr("2 1 1 inf")), ErrorCode::kNotFinite);
}

TEST(Sol, SurvivesDamagedFiles) {
  ExpectSurvivesDamage(FormatSol(RandomField(3, 9)), 3000, ParseSol);
  ExpectSurvivesDamage("3 3\n1 0 1\n2 0 2\n3 0 3\n", 3000, ParseMtr);
}

// Goal: a .sol file holds what gmsh and mmg would see in it.
// Method: meshio has no reader for .sol, so a few lines of Python read it by its description.
TEST(Sol, IsReadAsTextByOthers) {
  const TemporaryFolder folder;
  PointField field;
  field.component_count = 3;
  field.values = {0.1, -1e-300, 2.5, 3, 4, 5e22};
  ASSERT_TRUE(WriteField(folder.File("a.sol"), field).ok());
  EXPECT_EQ(Shell(std::string(PLIANT_PYTHON) + " -c \"w = open('" + folder.File("a.sol") +
                  "').read().split(); i = w.index('SolAtVertices'); print(w[i+1:i+4], "
                  "[float(x) for x in w[i+4:-1]])\""),
            "['2', '1', '3'] [0.1, -1e-300, 2.5, 3.0, 4.0, 5e+22]\n");
  EXPECT_EQ(ReadField(folder.File("a.sol")).value(), field);
}

}  // namespace
}  // namespace pliant::io
