// Displacements with tensors through the client library, against a real pliantd and the core in
// this process.

#include <gtest/gtest.h>

#include <vector>

#include "client/cpp/client.h"
#include "core/pliant/displace_tensors.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/remesher.h"
#include "tests/client/live/inputs.h"
#include "tests/client/live/pliantd_process.h"

namespace pliant::client {
namespace {

// Goal: what is displaced together with tensors of where it goes, for all vertices, for some, and
// with a formula beside them, has the bits of the core.
TEST(LiveDisplacement, WithTensorsGivesTheBitsOfTheCore) {
  PliantdProcess server;
  Client client = Client::Connect(server.address()).value();
  const auto session = client.CreateSession(Square(), Size("0.06")).value();
  const auto local = Remesher::Create(Square(), Size("0.06"), {}).value();
  const FunctionsSpec beside{.parts = {SizeMetric{"0.03 + 0.2*y"}}};
  for (int step = 0; step < 4; ++step) {
    SCOPED_TRACE(step);
    if (step > 0) {
      const bool is_of_all = step != 2;
      const FunctionsSpec* const functions = step == 3 ? &beside : nullptr;
      const Mesh& mesh = local->mesh();
      const Vec2 vector{step == 1 ? 0.05 : -0.03, 0.004};
      std::vector<VertexId> strip;
      std::vector<Metric> tensors;
      for (const VertexId id : LiveVertices(mesh)) {
        const Vec2 p = mesh.position(id);
        const bool moves = p.x > 0.3 && p.x < 0.7;
        if (moves) strip.push_back(id);
        if (!moves && !is_of_all) continue;
        tensors.push_back(Metric::Isotropic(0.05 + 0.02 * (moves ? p + vector : p).x));
      }
      const std::vector<Vec2> by(strip.size(), vector);
      TensorsAhead ahead{.displaced = strip, .by = by, .vertices = {}, .tensors = tensors};
      if (!is_of_all) ahead.vertices = strip;
      const Status sent = session->UpdateTensors(ahead, functions);
      ASSERT_TRUE(sent.ok()) << sent.error().message;
      const MetricLimits limits = local->limits();
      ASSERT_TRUE(SetTensorsAhead(*local, ahead, {limits, functions}).ok());
    }
    const auto report = session->Advance();
    ASSERT_TRUE(report.ok()) << report.error().message;
    ASSERT_TRUE(local->Step({}).ok());
    EXPECT_EQ(session->replica().summary(), local->Commit().summary);
  }
}

}  // namespace
}  // namespace pliant::client
