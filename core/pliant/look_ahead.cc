#include "core/pliant/look_ahead.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "core/mesh/place_map.h"
#include "core/pliant/displace.h"

namespace pliant {
namespace {

/// So many are asked at once.
constexpr std::size_t kAskedAtOnce = 64;

/// So many wait for each other before they walk far.
constexpr std::ptrdiff_t kFarAtOnce = 16;

/// Two vertices are near each other if they are so far apart in metric length, or less.
constexpr double kNear = 4;

/// Strays are looked through so many times for those who have a neighbour with an answer.
constexpr int kLookRounds = 16;

class Looker {
 public:
  Looker(const Mesh& mesh, const MetricField& field, std::span<const VertexId> vertices, Vec2 shift,
         const StopSignal* stop)
      : mesh_(mesh),
        field_(field),
        vertices_(vertices),
        shift_(shift),
        stopped_(stop),
        aheads_(vertices.size()) {}

  std::vector<Ahead> Run() {
    if (vertices_.empty()) return {};
    if (FieldWalks()) {
      asked_ = PlaceMap(mesh_.vertex_slots());
      asked_.Reserve(vertices_.size());
      // In a mesh that was refined the first quarter is spread over all of it: whoever of the rest
      // begins a new piece of the curve has a neighbour there.
      const std::size_t quarter = vertices_.size() / 4;
      GoAlong(StretchesOf(0, quarter));
      GoAlong(StretchesOf(quarter, vertices_.size()));
      AskStrays();
    } else {
      for (std::size_t k = 0; k < vertices_.size() && !stopped_(); ++k) AskSoon(k);
      AskNow();
    }
    return std::move(aheads_);
  }

 private:
  /// A part of the vertices, in order of slots: most of these lie in memory as in the plane.
  struct Stretch {
    std::size_t next;
    std::size_t end;
    std::int32_t hint;                     ///< The answer to the last question.
    bool is_far = true;                    ///< That is far from whoever is to be asked now.
    std::optional<std::size_t> turn = {};  ///< Who that is.
    std::optional<VertexId> passed = {};   ///< The last one that was looked at.
  };

  /// True if the field finds answers by way of hints.
  [[nodiscard]] bool FieldWalks() const {
    std::int32_t hint = MetricField::kNoHint;
    (void)field_.At(mesh_.position(vertices_[0]), hint);
    return hint != MetricField::kNoHint;
  }

  [[nodiscard]] std::vector<Stretch> StretchesOf(std::size_t begin, std::size_t end) const {
    std::vector<Stretch> stretches;
    for (std::size_t s = 0; s < kAskedAtOnce; ++s) {
      const std::size_t first = begin + s * (end - begin) / kAskedAtOnce;
      const std::size_t last = begin + (s + 1) * (end - begin) / kAskedAtOnce;
      if (first < last) stretches.push_back({first, last, mesh_.hint(vertices_[first])});
    }
    return stretches;
  }

  /// Asks along stretches, each from answer to answer. Leaves out strays: those who lie elsewhere
  /// than their neighbours in the order. Who must walk far waits for others who must, too.
  void GoAlong(std::vector<Stretch> stretches) {
    for (Stretch& stretch : stretches) GoOn(stretch);
    while (!stretches.empty() && !stopped_()) {
      const std::ptrdiff_t far_count = std::ranges::count_if(stretches, &Stretch::is_far);
      const bool walks_far = far_count >= kFarAtOnce || far_count == std::ssize(stretches);
      std::vector<Stretch*> asked;
      for (Stretch& stretch : stretches) {
        if (stretch.is_far && !walks_far) continue;
        if (stretch.is_far) BeginNear(stretch);
        aheads_[*stretch.turn].hint = stretch.hint;
        batch_.push_back(*stretch.turn);
        asked.push_back(&stretch);
      }
      AskNow();
      for (Stretch* const stretch : asked) {
        stretch->hint = aheads_[*stretch->turn].hint;
        GoOn(*stretch);
      }
      std::erase_if(stretches, [](const Stretch& stretch) { return !stretch.turn; });
    }
  }

  /// The turn of the next one that is near the one asked last, or begins another piece of the
  /// curve; nobody's at the end.
  void GoOn(Stretch& stretch) {
    while (stretch.next < stretch.end) {
      const std::size_t k = stretch.next++;
      if (stretch.next < stretch.end) mesh_.Prefetch(vertices_[stretch.next]);
      const bool goes_on = stretch.turn && AreNear(vertices_[k], vertices_[*stretch.turn]);
      const bool begins = !stretch.passed || AreNear(vertices_[k], *stretch.passed);
      stretch.passed = vertices_[k];
      if (!goes_on && !begins) {
        strays_.push_back(k);
        continue;
      }
      stretch.turn = k;
      stretch.is_far = !goes_on;
      if (stretch.is_far) BeginNear(stretch);
      return;
    }
    stretch.turn.reset();
  }

  /// Begins a piece of the curve at the answer of a neighbour, if there is one.
  void BeginNear(Stretch& stretch) const {
    const Ahead* const near = AnswerNear(vertices_[*stretch.turn]);
    if (near == nullptr) return;
    stretch.hint = near->hint;
    stretch.is_far = false;
  }

  [[nodiscard]] bool AreNear(VertexId a, VertexId b) const {
    return SquaredLength(mesh_.metric(a), mesh_.position(b) - mesh_.position(a)) <= kNear * kNear;
  }

  /// Asks for strays who have a neighbour with an answer, then for their neighbours, and so on; for
  /// the rest from where they are.
  void AskStrays() {
    for (int round = 0; round < kLookRounds && !strays_.empty() && !stopped_(); ++round) {
      std::vector<std::size_t> later;
      for (const std::size_t k : strays_) {
        const Ahead* const near = AnswerNear(vertices_[k]);
        if (near != nullptr) {
          aheads_[k].hint = near->hint;
          AskSoon(k);
        } else {
          later.push_back(k);
        }
      }
      AskNow();
      const bool gets_on = later.size() < strays_.size();
      strays_ = std::move(later);
      if (!gets_on) break;
    }
    for (const std::size_t k : strays_) {
      if (stopped_()) return;
      aheads_[k].hint = mesh_.hint(vertices_[k]);
      AskSoon(k);
    }
    AskNow();
  }

  /// The answer for a vertex nearby, or null.
  [[nodiscard]] const Ahead* AnswerNear(VertexId vertex) const {
    const TriangleRecord& triangle = mesh_.triangle(mesh_.vertex(vertex).triangle);
    const auto place_in = [&](const TriangleRecord& one) {
      for (const VertexId corner : one.vertices) {
        if (const std::int32_t place = asked_.At(corner); place != PlaceMap::kNone) return place;
      }
      return PlaceMap::kNone;
    };
    std::int32_t place = place_in(triangle);
    for (const TriangleId neighbor : triangle.neighbors) {
      if (place != PlaceMap::kNone) break;
      if (neighbor.valid()) place = place_in(mesh_.triangle(neighbor));
    }
    return place == PlaceMap::kNone ? nullptr : &aheads_[static_cast<std::size_t>(place)];
  }

  void AskSoon(std::size_t k) {
    batch_.push_back(k);
    if (batch_.size() == kAskedAtOnce) AskNow();
  }

  void AskNow() {
    questions_.clear();
    std::size_t kept = 0;
    for (const std::size_t k : batch_) {
      const std::optional<Vec2> place = PlaceAfter(mesh_, vertices_[k], shift_);
      if (!place) continue;
      questions_.push_back({*place, aheads_[k].hint, {}});
      batch_[kept++] = k;
    }
    field_.ProbeEach(questions_);
    for (std::size_t i = 0; i < kept; ++i) {
      const MetricField::Question& one = questions_[i];
      aheads_[batch_[i]] = {one.place, one.answer, one.hint};
      asked_.Add(vertices_[batch_[i]], static_cast<std::int32_t>(batch_[i]));
    }
    batch_.clear();
  }

  const Mesh& mesh_;
  const MetricField& field_;
  const std::span<const VertexId> vertices_;
  const Vec2 shift_;
  StopPoll stopped_;
  std::vector<Ahead> aheads_;
  PlaceMap asked_;                   // Whose aheads_ are known.
  std::vector<std::size_t> strays_;  // Places in vertices_, as below.
  std::vector<std::size_t> batch_;   // Whoever is asked next.
  std::vector<MetricField::Question> questions_;
};

}  // namespace

std::vector<Ahead> LookAhead(const Mesh& mesh, const MetricField& field,
                             std::span<const VertexId> vertices, Vec2 shift,
                             const StopSignal* stop) {
  return Looker(mesh, field, vertices, shift, stop).Run();
}

}  // namespace pliant
