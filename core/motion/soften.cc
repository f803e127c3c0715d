#include "core/motion/soften.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/mesh/id_bits.h"
#include "core/mesh/segment_edges.h"
#include "core/motion/advance.h"
#include "core/motion/chords.h"
#include "core/motion/contact.h"
#include "core/motion/plan.h"
#include "core/pliant/mesh_change.h"

namespace pliant {
namespace {

/// Contacts after each of which the chords that meet are given up; one more, and none is drawn in
/// this update. Each costs a pass over the constrained edges.
constexpr int kContactsMax = 12;

/// Times that corners are moved and found to be stuck. Each costs what moving them costs.
constexpr int kTriesMax = 4;

/// Motion of corners onto chords, as a change of a session's mesh.
class Softening final : public MeshChange {
 public:
  Softening(std::vector<VertexId> corners, double tolerance)
      : corners_(std::move(corners)), tolerance_(tolerance) {}

  /// True if there is something to do.
  [[nodiscard]] bool FindsChords(const Mesh& mesh) const {
    return !ChooseChords(mesh, corners_, tolerance_).empty();
  }

  Result<Outcome> Apply(MeshEdit& edit) override {
    const Mesh& mesh = edit.mesh();
    stuck_.clear();
    chords_ = ChooseChords(mesh, corners_, tolerance_);
    PLIANT_ASSIGN_OR_RETURN(const MotionPlan plan, PlanWithoutContact(mesh));
    if (stop_asked()) return Stopped();
    std::vector<VertexId> disturbed;
    if (!plan.movers().empty()) {
      Advance advance(edit, plan);
      const double reached = advance.RunTo(1);
      if (stop_asked()) return Stopped();
      if (reached < 1) return Stuck(mesh, advance.Blockers());
      disturbed = advance.Disturbed().all;
    }
    for (const Chord& chord : chords_) {
      if (!Ascends(mesh, chord)) return Stuck(mesh, {});
    }
    return OutcomeOf(mesh, disturbed, Join(edit));
  }

  /// Leaves corners alone that could not be moved. @return false if none is known
  bool GiveUpStuck() {
    std::ranges::sort(stuck_);
    const auto given_up = std::erase_if(
        corners_, [&](VertexId corner) { return std::ranges::binary_search(stuck_, corner); });
    return given_up > 0;
  }

  [[nodiscard]] std::int64_t softened_count() const { return softened_count_; }

 private:
  /// A constrained edge as a piece of its chord.
  struct Piece {
    EdgeId edge;
    NewEdge now;
  };

  /// The motion onto the chords, less those at which boundaries would meet.
  Result<MotionPlan> PlanWithoutContact(const Mesh& mesh) {
    for (int contacts = 0;; ++contacts) {
      PLIANT_ASSIGN_OR_RETURN(MotionPlan plan, MotionPlan::Make(mesh, Request(mesh), stop()));
      plan.FindRiders(mesh);
      const std::optional<Contact> contact = FindContact(mesh, plan);
      if (!contact) return plan;
      const std::size_t before = chords_.size();
      std::erase_if(chords_, [&](const Chord& chord) {
        return IsOf(chord, mesh, contact->first) || IsOf(chord, mesh, contact->second);
      });
      if (chords_.size() == before || contacts == kContactsMax) chords_.clear();
    }
  }

  [[nodiscard]] MotionRequest Request(const Mesh& mesh) const {
    MotionRequest request;
    for (const Chord& chord : chords_) {
      for (std::size_t i = 1; i + 1 < chord.corners.size(); ++i) {
        request.vertices.push_back(chord.corners[i]);
        request.positions.push_back(chord.PositionOf(mesh, i));
      }
    }
    return request;
  }

  static bool IsOf(const Chord& chord, const Mesh& mesh, EdgeId edge) {
    return edge.valid() &&
           std::ranges::find(chord.segments, mesh.edge(edge).segment) != chord.segments.end();
  }

  /// Notes which corners are in each other's way: those of the chords whose edges would meet, or
  /// all if these are not known.
  Error Stuck(const Mesh& mesh, std::pair<EdgeId, EdgeId> blockers) {
    for (const Chord& chord : chords_) {
      if (!IsOf(chord, mesh, blockers.first) && !IsOf(chord, mesh, blockers.second)) continue;
      stuck_.insert(stuck_.end(), chord.corners.begin() + 1, chord.corners.end() - 1);
    }
    if (stuck_.empty()) stuck_ = corners_;
    return {ErrorCode::kCrossingSegments, "corners are in each other's way", {}};
  }

  /// The edges of a chord from end to end.
  static std::vector<Piece> PiecesOf(const Mesh& mesh, const Chord& chord) {
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < chord.segments.size(); ++i) {
      const double begin = chord.parameters[i];
      const double end = chord.parameters[i + 1];
      const bool forth =
          mesh.segments()[static_cast<std::size_t>(chord.segments[i])].a == chord.corners[i];
      // The ends have their exact parameters.
      const auto on_chord = [&](double t) {
        const double along = forth ? t : 1 - t;
        return along == 0 ? begin : along == 1 ? end : begin + along * (end - begin);
      };
      const std::size_t first = pieces.size();
      ForEachPiece(mesh, chord.segments[i], [&](EdgeId id) {
        const EdgeRecord& edge = mesh.edge(id);
        NewEdge now{edge.vertices, {on_chord(edge.parameters[0]), on_chord(edge.parameters[1])}};
        now.tag = edge.tag;
        if (!forth) {
          std::swap(now.vertices[0], now.vertices[1]);
          std::swap(now.parameters[0], now.parameters[1]);
        }
        pieces.push_back({id, now});
      });
      if (!forth) std::reverse(pieces.begin() + static_cast<std::ptrdiff_t>(first), pieces.end());
    }
    return pieces;
  }

  static bool Ascends(const Mesh& mesh, const Chord& chord) {
    return std::ranges::all_of(PiecesOf(mesh, chord), [](const Piece& piece) {
      return piece.now.parameters[0] < piece.now.parameters[1];
    });
  }

  /// Makes each chord one segment. @return the vertices inside them, ascending
  std::vector<VertexId> Join(MeshEdit& edit) {
    const Mesh& mesh = edit.mesh();
    std::vector<std::int32_t> removed;
    std::vector<SegmentRecord> added;
    std::vector<std::vector<Piece>> pieces;
    for (const Chord& chord : chords_) {
      removed.insert(removed.end(), chord.segments.begin(), chord.segments.end());
      added.push_back({chord.corners.front(), chord.corners.back()});
      pieces.push_back(PiecesOf(mesh, chord));
    }
    const std::vector<std::int32_t> places = edit.ReplaceSegments(removed, added);
    softened_count_ = 0;
    std::vector<VertexId> inside;
    for (std::size_t i = 0; i < chords_.size(); ++i) {
      for (Piece& piece : pieces[i]) {
        piece.now.segment = places[i];
        edit.SetEdge(piece.edge, piece.now);
        if (piece.now.vertices[1] != added[i].b) inside.push_back(piece.now.vertices[1]);
      }
      const std::vector<VertexId>& corners = chords_[i].corners;
      for (std::size_t k = 1; k + 1 < corners.size(); ++k) edit.Unfix(corners[k]);
      softened_count_ += static_cast<std::int64_t>(corners.size()) - 2;
    }
    std::ranges::sort(inside);
    return inside;
  }

  static Outcome OutcomeOf(const Mesh& mesh, const std::vector<VertexId>& disturbed,
                           std::vector<VertexId> inside) {
    Outcome outcome;
    IdBits<VertexId> all(mesh.vertex_slots());
    for (const VertexId vertex : disturbed) all.Add(vertex);
    for (const VertexId vertex : inside) all.Add(vertex);
    outcome.disturbed = all.Ascending();
    outcome.drifting = inside;
    outcome.moved = std::move(inside);
    return outcome;
  }

  std::vector<VertexId> corners_;
  const double tolerance_;
  std::vector<Chord> chords_;
  std::vector<VertexId> stuck_;  // Of the last Apply.
  std::int64_t softened_count_ = 0;
};

}  // namespace

Result<SoftenReport> SoftenBoundary(Remesher& remesher) {
  const Options& options = remesher.options();
  const Mesh& mesh = remesher.mesh();
  if (!(options.boundary_tolerance > 0) || !(options.permissions == Permissions{}) ||
      remesher.revision() == Revision::kNone) {
    return SoftenReport{};
  }
  std::vector<VertexId> corners = remesher.WhereTroublesMayBe().changed;
  std::erase_if(corners, [&](VertexId vertex) { return !IsSoftCorner(mesh, vertex); });
  Softening softening(std::move(corners), options.boundary_tolerance);
  for (int tries = 0; tries < kTriesMax && softening.FindsChords(mesh); ++tries) {
    const Status status = remesher.Apply(softening);
    if (status.ok()) return SoftenReport{softening.softened_count()};
    const ErrorCode code = status.error().code;
    if (code == ErrorCode::kFrozen || code == ErrorCode::kCancelled) break;
    if (code != ErrorCode::kCrossingSegments || !softening.GiveUpStuck()) return status.error();
  }
  return SoftenReport{};
}

}  // namespace pliant
