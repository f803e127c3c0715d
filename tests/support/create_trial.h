#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pliant/v1/session.pb.h"
#include "server/blobs.h"
#include "server/convert.h"
#include "server/staged_engine.h"
#include "tests/support/pieces.h"
#include "tests/support/wire_arrays.h"

/// A CreateSession from its bytes to the first mesh, as server/creation.cc takes it.
namespace pliant::test {

inline constexpr std::int32_t kCreateVerticesMax = 500;
inline constexpr std::int64_t kCreateVisitsMax = 2'000;

/// What a session may start from: domains and a mesh, metrics of several kinds, options; with and
/// without arrays that are sent ahead.
inline std::vector<std::vector<Piece>> CreateCorpus() {
  std::vector<std::vector<Piece>> corpus;
  const auto add = [&](const v1::CreateSession& create) {
    v1::CreateSessionRequest request;
    *request.mutable_create() = create;
    corpus.push_back({{.choice = 0, .bytes = request.SerializeAsString()}});
  };
  add(UnitSquare("0.2 + 0.1*x"));
  add(TwoTriangles());
  v1::CreateSession parts = UnitSquare("0.3");
  *parts.mutable_domain()->mutable_points() =
      Doubles({0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0, 0.5, 1, 0.1, 0.4, 0.3, 0.4, 0.2, 0.6}, 2);
  *parts.mutable_domain()->mutable_segments() =
      Ints({0, 4, 4, 1, 1, 2, 2, 5, 5, 3, 3, 0, 4, 5, 6, 7, 7, 8, 8, 6}, 2);
  *parts.mutable_domain()->mutable_segment_tags() = Ints({1, 1, 2, 3, 3, 4, 5, 6, 6, 6});
  *parts.mutable_domain()->mutable_holes() = Doubles({0.2, 0.45}, 2);
  parts.mutable_options()->set_seed(7);
  parts.mutable_options()->set_vertices_max(300);
  parts.mutable_metric()->mutable_limits()->set_gradation(1.5);
  (*parts.mutable_labels())["case"] = "7";
  add(parts);
  v1::CreateSession background = UnitSquare();
  v1::BackgroundMetric& metric =
      *background.mutable_metric()->mutable_sources(0)->mutable_background();
  *metric.mutable_mesh()->mutable_points() = Doubles({0, 0, 2, 0, 0, 2}, 2);
  *metric.mutable_mesh()->mutable_triangles() = Ints({0, 1, 2}, 3);
  *metric.mutable_tensors() = Doubles({9, 0, 9, 16, 1, 9, 25, 0, 25}, 3);
  add(background);
  // The same domain, its points sent ahead.
  v1::CreateSession ahead = UnitSquare("0.4");
  v1::CreateSessionRequest chunk;
  chunk.mutable_chunk()->set_blob_id(1);
  chunk.mutable_chunk()->set_total_bytes(64);
  chunk.mutable_chunk()->set_data(ahead.domain().points().data());
  ahead.mutable_domain()->mutable_points()->clear_data();
  ahead.mutable_domain()->mutable_points()->set_blob_id(1);
  add(ahead);
  corpus.back().insert(corpus.back().begin(), {.choice = 0, .bytes = chunk.SerializeAsString()});
  return corpus;
}

/// How far the bytes of a trial came.
enum class CreateEnd { kNotParsed, kRefused, kMeshed };

/// The mesh that an input makes, advanced for a while; what is wrong with it, or nothing.
inline std::string MeshAndCheck(server::EngineInput input, CreateEnd* end) {
  input.options.vertices_max = std::min(input.options.vertices_max, kCreateVerticesMax);
  Result<server::StagedEngine> engine =
      server::StagedEngine::Create(std::move(input), server::RemesherFactory());
  if (!engine.ok()) return engine.error().message.empty() ? "a refusal says nothing" : "";
  const Result<Progress> progress = engine->Step({.visits_max = kCreateVisitsMax});
  if (!progress.ok()) return progress.error().message.empty() ? "a refusal says nothing" : "";
  static_cast<void>(engine->Commit());
  if (end != nullptr) *end = CreateEnd::kMeshed;
  const std::vector<std::string> faults = engine->engine().Validate();
  return faults.empty() ? "" : faults.front();
}

/// Pieces are the messages of one upload, in order. @return what is wrong, or nothing
/// @param end  unless null: how far it came
inline std::string TryCreate(std::string_view bytes, CreateEnd* end = nullptr) {
  server::BlobAssembler blobs;
  for (const Piece& piece : Cut(bytes)) {
    v1::CreateSessionRequest request;
    if (!request.ParseFromString(piece.bytes)) return "";
    if (end != nullptr) *end = CreateEnd::kRefused;
    if (request.has_chunk()) {
      const Status status = blobs.Add(std::move(*request.mutable_chunk()));
      if (!status.ok()) return status.error().message.empty() ? "a refusal says nothing" : "";
      continue;
    }
    if (!request.has_create()) return "";
    v1::CreateSession& create = *request.mutable_create();
    if (!blobs.Resolve(create).ok()) return "";
    Result<server::SessionInput> input =
        server::ConvertCreate(create, {.vertices_max = kCreateVerticesMax});
    if (!input.ok()) {
      if (input.error().message.empty()) return "a refusal says nothing";
      return input.error().code == ErrorCode::kInternal ? input.error().message : "";
    }
    return MeshAndCheck(std::move(input->engine), end);
  }
  return "";
}

}  // namespace pliant::test
