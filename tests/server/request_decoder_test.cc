// Goal: no bytes that arrive as a request crash the decoder, throw, or get past it half checked:
// each becomes a command, or a refusal with a sentence.
// Method: valid requests of every kind, from the tests' own builders, with bits flipped, bytes cut,
// doubled and spliced; what still parses is resolved and converted as a stream would. The
// sanitizers watch. Replay: PLIANT_SEED=17 server_tests --gtest_filter='RequestDecoder.*'
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <variant>
#include <vector>

#include "core/base/rng.h"
#include "server/blobs.h"
#include "server/convert.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

constexpr RequestLimits kLimits{.vertices_max = 10'000};

std::vector<std::string> EditCorpus() {
  std::vector<std::string> corpus;
  const auto add = [&](auto&& fill) {
    v1::EditRequest request;
    request.set_update_id(7);
    fill(request);
    corpus.push_back(request.SerializeAsString());
  };
  add([](auto& r) { r.mutable_metric()->add_sources()->mutable_size()->set_size("0.1 + x"); });
  add([](auto& r) {
    v1::ExpressionMetric& e = *r.mutable_metric()->add_sources()->mutable_expression();
    e.set_m11("1");
    e.set_m12("0");
    e.set_m22("2");
    r.mutable_metric()->mutable_limits()->set_gradation(1.5);
  });
  add([](auto& r) {
    v1::VertexMetric& v = *r.mutable_metric()->add_sources()->mutable_vertices();
    v.set_revision(3);
    *v.mutable_vertex_ids() = test::Ints({1, 2});
    *v.mutable_tensors() = test::Doubles({1, 0, 1, 2, 0, 2}, 3);
  });
  add([](auto& r) { *r.mutable_metric() = test::TwoTriangles().metric(); });
  add([](auto& r) {
    v1::SolutionMetric& s = *r.mutable_metric()->add_sources()->mutable_solution();
    s.mutable_field()->set_location(v1::FIELD_LOCATION_VERTEX);
    *s.mutable_field()->mutable_values() = test::Doubles({1, 2, 3}, 1);
    s.set_complexity(100);
  });
  add([](auto& r) {
    v1::BoundaryUpdate& b = *r.mutable_boundary();
    *b.mutable_vertices()->mutable_vertex_ids() = test::Ints({4});
    *b.mutable_vertices()->mutable_positions() = test::Doubles({0.5, 0.25}, 2);
    b.add_tags()->mutable_rotation()->set_angle_rad(1);
    b.mutable_tags(0)->add_tags(3);
    b.add_tags()->mutable_path()->add_x(1);
  });
  add([](auto& r) {
    *r.mutable_nodes()->mutable_vertices()->mutable_positions() = test::Doubles({0, 0, 1, 1}, 2);
  });
  add([](auto& r) {
    v1::FieldValues& f = *r.mutable_fields()->add_values();
    f.set_name("u");
    f.set_location(v1::FIELD_LOCATION_TRIANGLE);
    *f.mutable_values() = test::Doubles({1, 2, 3, 4}, 2);
    r.mutable_fields()->set_transfer(v1::TRANSFER_BOUNDED);
  });
  add([](auto& r) {
    v1::ConstraintUpdate& c = *r.mutable_constraints();
    *c.mutable_frozen_vertices() = test::Ints({1, 2, 3});
    *c.mutable_frozen_edges() = test::Ints({0});
    c.add_frozen_regions(2);
    c.add_restrictions(v1::RESTRICTION_NO_SWAP);
    c.set_revision(1);
  });
  add([](auto& r) { r.mutable_options()->set_hops_max(4); });
  add([](auto& r) { r.mutable_rollback()->set_to_revision(2); });
  add([](auto& r) { r.mutable_advance()->set_budget_ms(20); });
  add([](auto& r) { r.mutable_discard(); });
  return corpus;
}

std::string Mutated(std::string bytes, const std::string& other, Rng& rng) {
  for (std::uint64_t count = 1 + rng.Below(2); count > 0; --count) {
    if (bytes.empty()) return other;
    const auto at = static_cast<std::size_t>(rng.Below(bytes.size()));
    switch (rng.Below(5)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << rng.Below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(rng.Below(256));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, 1 + rng.Below(16)));
        break;
      default:
        bytes.insert(at, other.substr(rng.Below(other.size())));
        break;
    }
  }
  return bytes;
}

std::uint64_t FirstSeed() {
  const char* seed = std::getenv("PLIANT_SEED");
  return seed != nullptr ? std::strtoull(seed, nullptr, 10) : 0;
}

/// True for the kinds of command that a stream hands to ConvertUpdate.
bool IsUpdate(const v1::EditRequest& request) {
  return !request.has_open() && !request.has_chunk() && !request.has_cancel() &&
         !request.has_acknowledge() && request.command_case() != v1::EditRequest::COMMAND_NOT_SET;
}

/// Protobuf writes a line for every text that is no UTF-8.
class RequestDecoder : public ::testing::Test {
 protected:
  google::protobuf::LogSilencer silencer_;
};

TEST_F(RequestDecoder, EveryEditRequestIsACommandOrARefusal) {
  const std::vector<std::string> corpus = EditCorpus();
  int parsed = 0;
  int refused = 0;
  const std::uint64_t first = FirstSeed();
  for (std::uint64_t seed = first; seed < first + 40'000; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Rng rng(seed);
    v1::EditRequest request;
    const std::string& one = corpus[rng.Below(corpus.size())];
    const std::string& other = corpus[rng.Below(corpus.size())];
    if (!request.ParseFromString(Mutated(one, other, rng)) || !IsUpdate(request)) continue;
    ++parsed;
    BlobAssembler blobs;
    if (const Status status = blobs.Resolve(request); !status.ok()) {
      EXPECT_FALSE(status.error().message.empty());
      ++refused;
      continue;
    }
    const UpdateCommand command = ConvertUpdate(request, kLimits);
    EXPECT_EQ(command.update_id, request.update_id());
    if (const auto* bad = std::get_if<BadUpdate>(&command.body)) {
      EXPECT_FALSE(bad->error.message.empty());
      EXPECT_NE(bad->error.code, ErrorCode::kInternal);
      ++refused;
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(parsed, 5'000) << "the mutations destroy too much";
  EXPECT_GT(refused, 500) << "the mutations hardly touch what is checked";
  EXPECT_LT(refused, parsed);
}

TEST_F(RequestDecoder, EveryCreateIsAnInputOrARefusal) {
  const std::vector<std::string> corpus{test::UnitSquare("0.1").SerializeAsString(),
                                        test::TwoTriangles().SerializeAsString()};
  int taken = 0;
  int refused = 0;
  const std::uint64_t first = FirstSeed();
  for (std::uint64_t seed = first; seed < first + 20'000; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Rng rng(seed);
    v1::CreateSession create;
    if (!create.ParseFromString(Mutated(corpus[rng.Below(2)], corpus[rng.Below(2)], rng))) continue;
    BlobAssembler blobs;
    if (!blobs.Resolve(create).ok()) continue;
    const Result<SessionInput> input = ConvertCreate(create, kLimits);
    if (input.ok()) {
      ++taken;
      EXPECT_LE(input->engine.options.vertices_max, kLimits.vertices_max);
    } else {
      ++refused;
      EXPECT_FALSE(input.error().message.empty());
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace pliant::server
