#include "core/pliant/carry.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/mesh/frozen_mesh.h"
#include "core/mesh/place_map.h"
#include "core/mesh/scan_pays.h"
#include "core/mesh/star.h"
#include "core/pliant/displace.h"
#include "core/pliant/look_ahead.h"
#include "core/pliant/metric_shift.h"
#include "core/pliant/nodal_field.h"
#include "core/pliant/slide.h"

namespace pliant {
namespace {

/// Where fewer vertices than this change, the loop is done before a shift is found.
constexpr std::size_t kChangedMin = 1500;
/// Vertices that are asked for the shift.
constexpr std::size_t kSampledChanges = 96;
/// At most this share of the differences between new and old tensors may be left where the new ones
/// are compared with the old ones from where they came.
constexpr double kHasCome = 0.3;
/// At least this share of what changes must be carried.
constexpr double kCarriedShare = 0.5;
/// A vertex is carried if that leaves this share of the change of its tensor, or less.
constexpr double kChangeLeft = 0.5;
/// And if the new metric changes by this much, as a multiple of the tolerance, over the shift. It
/// is a rule of the place: tensors remember changes below the tolerance of updates before, and a
/// band that goes by these has a ragged rim, which runs over vertices far beyond the front.
constexpr double kRimOfBand = 1.5;

class Carrier {
 public:
  Carrier(MeshEdit& edit, const MetricField& field, const CarryOptions& options)
      : edit_(edit),
        mesh_(edit.mesh()),
        field_(field),
        recalled_(options.recalled),
        tolerance_(options.tolerance),
        signal_(options.stop),
        stopped_(options.stop) {}

  std::optional<CarriedUpdate> Run(WantedTensors wanted) {
    CarriedUpdate update{.wanted = std::move(wanted), .disturbed = {}};
    const std::vector<std::size_t> changed = KeepChanged(update.wanted);
    const bool carries = changed.size() >= kChangedMin && FindCarried(update.wanted, changed);
    if (carries) CloseRanks();
    if (signal_ != nullptr && signal_->asked()) return std::nullopt;
    if (carries) Move(update);
    return update;
  }

 private:
  /// A vertex that is carried, and what it will want then.
  struct Carried {
    VertexId vertex;
    Vec2 to;
    Metric tensor;
    std::int32_t hint = 0;
  };

  [[nodiscard]] bool Moves(VertexId vertex) const { return moves_[vertex.index()]; }

  /// True if enough of what changes can be carried.
  bool FindCarried(const WantedTensors& wanted, const std::vector<std::size_t>& changed) {
    const std::optional<Vec2> shift = FindShift(SamplesOf(wanted, changed), field_, signal_);
    if (!shift) return false;
    shift_ = *shift;
    const auto before = std::make_shared<FrozenMesh>(edit_);
    if (!HasCome(wanted, changed, *before)) return false;
    if (recalled_ != nullptr) shift_ = LookBack(wanted, changed, before);
    ChooseCarried(wanted, changed);
    return static_cast<double>(carried_.size()) >=
           kCarriedShare * static_cast<double>(changed.size());
  }

  /// True if what the metric has become was there before, one shift back. Where it was not,
  /// something has appeared rather than moved: then every shift that leads out of it explains what
  /// has become of the old tensors, and whoever goes along leaves where more vertices are wanted.
  [[nodiscard]] bool HasCome(const WantedTensors& wanted, const std::vector<std::size_t>& changed,
                             FrozenMesh& before) const {
    double all = 0;
    double left = 0;
    for (const std::size_t i : SampleOf(changed)) {
      const VertexId vertex = wanted.vertices[i];
      const LogMetric now = Log(wanted.tensors[i]);
      std::int32_t hint = mesh_.vertex(vertex).triangle.value();
      all += LogDistance(now, Log(mesh_.metric(vertex)));
      left += LogDistance(now, before.LogAt(mesh_.position(vertex) - shift_, hint));
    }
    return left < kHasCome * all;
  }

  /// The shift as what was sent says it: that is exact where it was sent, and the metric of before
  /// knows what is between vertices, where the tensors ahead of a thin front do not.
  [[nodiscard]] Vec2 LookBack(const WantedTensors& wanted, const std::vector<std::size_t>& changed,
                              const std::shared_ptr<FrozenMesh>& before) const {
    std::vector<PlacedTensor> samples;
    for (const std::size_t i : SampleOf(changed)) {
      const VertexRecord& record = mesh_.vertex(wanted.vertices[i]);
      samples.push_back({record.position, wanted.tensors[i], record.triangle.value()});
    }
    return -1 * RefineShift(samples, NodalField(before), -1 * shift_);
  }

  void Move(CarriedUpdate& update) {
    std::vector<Displacement> list;
    list.reserve(carried_.size());
    for (const Carried& one : carried_) list.push_back({one.vertex, one.to});
    std::optional<Displaced> displaced = Displace(edit_, list, Behind::kRefilled);
    if (displaced) Report(*std::move(displaced), update);
  }

  /// Places in `wanted` of the vertices that could move and whose metric changes. Those whose
  /// metric does not are left out of `wanted`, so that nobody has to find this again.
  [[nodiscard]] std::vector<std::size_t> KeepChanged(WantedTensors& wanted) {
    std::vector<std::size_t> changed;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
      if (stopped_()) break;
      const VertexId vertex = wanted.vertices[i];
      const Metric& old = mesh_.metric(vertex);
      if (wanted.tensors[i] == old || !(RelativeChange(old, wanted.tensors[i]) > tolerance_)) {
        continue;
      }
      if (IsDisplaceable(mesh_, vertex) || IsSlidable(mesh_, vertex)) changed.push_back(kept);
      wanted.vertices[kept] = vertex;
      wanted.tensors[kept++] = wanted.tensors[i];
    }
    wanted.vertices.resize(kept);
    wanted.tensors.resize(kept);
    return changed;
  }

  [[nodiscard]] static std::vector<std::size_t> SampleOf(const std::vector<std::size_t>& changed) {
    std::vector<std::size_t> sample;
    for (std::size_t k = 0; k < kSampledChanges; ++k) {
      sample.push_back(changed[k * changed.size() / kSampledChanges]);
    }
    return sample;
  }

  [[nodiscard]] std::vector<PlacedTensor> SamplesOf(const WantedTensors& wanted,
                                                    const std::vector<std::size_t>& changed) const {
    std::vector<PlacedTensor> samples;
    for (const std::size_t i : SampleOf(changed)) {
      const VertexId vertex = wanted.vertices[i];
      samples.push_back({mesh_.position(vertex), mesh_.metric(vertex), mesh_.hint(vertex)});
    }
    return samples;
  }

  void ChooseCarried(const WantedTensors& wanted, const std::vector<std::size_t>& changed) {
    moves_.assign(static_cast<std::size_t>(mesh_.vertex_slots()), false);
    std::vector<VertexId> vertices;
    vertices.reserve(changed.size());
    for (const std::size_t i : changed) vertices.push_back(wanted.vertices[i]);
    std::vector<Ahead> aheads = LookAhead(mesh_, field_, vertices, shift_, signal_);
    if (recalled_ != nullptr) recalled_->SetShift(shift_);
    for (std::size_t k = 0; k < changed.size(); ++k) {
      if (stopped_()) return;
      const std::size_t i = changed[k];
      const VertexId vertex = vertices[k];
      const Metric& old = mesh_.metric(vertex);
      if (!aheads[k].tensor) continue;
      if (recalled_ != nullptr) Recall(aheads[k], vertex);
      const std::optional<Metric>& ahead = aheads[k].tensor;
      if (!(RelativeChange(wanted.tensors[i], *ahead) > kRimOfBand * tolerance_)) continue;
      const double left = RelativeChange(old, *ahead);
      if (left <= std::max(tolerance_, kChangeLeft * RelativeChange(old, wanted.tensors[i]))) {
        Carry(vertex, aheads[k]);
      }
    }
  }

  void Ask(Ahead& ahead, VertexId vertex) const {
    const std::optional<Vec2> place = PlaceAfter(mesh_, vertex, shift_);
    if (!place) return;
    ahead.place = *place;
    ahead.tensor = field_.Probe(*place, ahead.hint);
  }

  /// Asks again where a triangle of what was sent is too large to know what the vertex had.
  void Recall(Ahead& ahead, VertexId vertex) const {
    const VertexRecord& record = mesh_.vertex(vertex);
    if (!(RelativeChange(record.metric, *ahead.tensor) > tolerance_)) return;
    const std::optional<Metric> recalled =
        recalled_->Recall({record.metric, ahead.place, ahead.hint, record.triangle.value()});
    if (!recalled) return;
    const bool slides = ahead.place != record.position + shift_;
    ahead.tensor = slides ? recalled_->At(ahead.place, ahead.hint) : *recalled;
  }

  /// @pre ahead.tensor
  void Carry(VertexId vertex, const Ahead& ahead) {
    moves_[vertex.index()] = true;
    carried_.push_back({vertex, ahead.place, *ahead.tensor, ahead.hint});
  }

  /// Lets the carried ones be one piece: who is surrounded by them is carried too, whatever becomes
  /// of its metric, and who is alone among others is not.
  void CloseRanks() {
    std::vector<VertexId> waiting;
    const std::vector<bool> at_rim = FindRim();
    std::erase_if(carried_, [&](const Carried& one) {
      if (stopped_() || (!at_rim.empty() && !at_rim[one.vertex.index()])) return false;
      const auto moving = CountMoving(one.vertex);
      const bool alone = 4 * moving <= std::ssize(star_.ring());
      if (alone) moves_[one.vertex.index()] = false;
      if (!alone && moving < std::ssize(star_.ring())) AddRestingNeighbors(waiting);
      return alone;
    });
    while (!waiting.empty() && !stopped_()) {
      const VertexId vertex = waiting.back();
      waiting.pop_back();
      if (Moves(vertex) || !PlaceAfter(mesh_, vertex, shift_)) continue;
      if (2 * CountMoving(vertex) <= std::ssize(star_.ring())) continue;
      Ahead ahead{.place = {}, .tensor = {}, .hint = mesh_.hint(vertex)};
      Ask(ahead, vertex);
      if (!ahead.tensor) continue;
      Carry(vertex, ahead);
      AddRestingNeighbors(waiting);
    }
    place_of_ = PlaceMap(mesh_.vertex_slots());
    place_of_.Reserve(carried_.size());
    for (std::size_t k = 0; k < carried_.size(); ++k) {
      place_of_.Add(carried_[k].vertex, static_cast<std::int32_t>(k));
    }
  }

  /// The vertices at triangles of which not all corners are carried, by slot: to read all triangles
  /// in order takes less time than to gather the stars of many vertices. Empty where few are
  /// carried. When one of them is then left alone, its neighbours are at a rim, too; they would
  /// only propose it again, in vain.
  [[nodiscard]] std::vector<bool> FindRim() const {
    std::vector<bool> at_rim;
    if (!ScanPays(mesh_, std::ssize(carried_))) return at_rim;
    at_rim.assign(static_cast<std::size_t>(mesh_.vertex_slots()), false);
    for (std::int32_t t = 0; t < mesh_.triangle_slots(); ++t) {
      const TriangleRecord& triangle = mesh_.triangle(TriangleId(t));
      if (!triangle.live) continue;
      const auto& v = triangle.vertices;
      if (Moves(v[0]) && Moves(v[1]) && Moves(v[2])) continue;
      for (const VertexId corner : v) at_rim[corner.index()] = true;
    }
    return at_rim;
  }

  /// Gathers the star of a vertex and counts its neighbours that are carried.
  std::ptrdiff_t CountMoving(VertexId vertex) {
    star_.Gather(mesh_, vertex);
    return std::count_if(star_.ring().begin(), star_.ring().end(),
                         [&](VertexId other) { return Moves(other); });
  }

  /// Of the center of the star.
  void AddRestingNeighbors(std::vector<VertexId>& nodes) const {
    for (const VertexId other : star_.ring()) {
      if (!Moves(other)) nodes.push_back(other);
    }
  }

  /// False for a vertex on a wall whose way was blocked.
  [[nodiscard]] bool HasArrived(const Carried& one) const {
    return mesh_.position(one.vertex) == one.to;
  }

  void Report(Displaced displaced, CarriedUpdate& update) {
    WantedTensors& wanted = update.wanted;
    std::vector<bool> told(carried_.size(), false);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
      const VertexId vertex = wanted.vertices[i];
      if (!mesh_.IsLive(vertex)) continue;
      const std::int32_t place = place_of_.At(vertex);
      Metric tensor = wanted.tensors[i];
      if (place != PlaceMap::kNone && HasArrived(carried_[static_cast<std::size_t>(place)])) {
        const auto k = static_cast<std::size_t>(place);
        tensor = carried_[k].tensor;
        edit_.Hint(vertex) = carried_[k].hint;
        told[k] = true;
      }
      wanted.vertices[kept] = vertex;
      wanted.tensors[kept++] = tensor;
    }
    wanted.vertices.resize(kept);
    wanted.tensors.resize(kept);
    for (std::size_t k = 0; k < carried_.size(); ++k) {
      if (told[k] || !mesh_.IsLive(carried_[k].vertex) || !HasArrived(carried_[k])) continue;
      wanted.vertices.push_back(carried_[k].vertex);
      wanted.tensors.push_back(carried_[k].tensor);
    }
    for (const VertexId vertex : displaced.created) {
      wanted.vertices.push_back(vertex);
      wanted.tensors.push_back(field_.At(mesh_.position(vertex), edit_.Hint(vertex)));
    }
    update.disturbed = std::move(displaced.disturbed);
    update.carried_count = std::ssize(carried_);
    update.removed_count = displaced.removed_count;
  }

  MeshEdit& edit_;
  const Mesh& mesh_;
  const MetricField& field_;
  RecalledField* const recalled_;
  const double tolerance_;
  const StopSignal* const signal_;
  StopPoll stopped_;
  Vec2 shift_;
  std::vector<Carried> carried_;
  std::vector<bool> moves_;  // By slot.
  PlaceMap place_of_;        // In carried_.
  Star star_;
};

}  // namespace

std::optional<CarriedUpdate> CarryAlong(MeshEdit& edit, const MetricField& field,
                                        WantedTensors wanted, const CarryOptions& options) {
  return Carrier(edit, field, options).Run(std::move(wanted));
}

}  // namespace pliant
