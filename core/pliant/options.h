#pragma once

#include <cstdint>

#include "core/base/stop_signal.h"

namespace pliant {

/// Which pliant loop runs.
enum class Variant {
  /// The default: the first mesh is built from coarse to fine, each level by kCooled from a
  /// converged mesh of twice the size with its edges halved; updates are kCooled's.
  kNested,
  /// Nodes are taken in the order in which they became active and grow older with
  /// every visit, which cools them until the loop ends. Always ends (core/README.md has the proof).
  kCooled,
  /// The paper's loop to the letter: random picking, alpha 0.2, no cooling. Ends on metrics that a
  /// mesh can meet; otherwise it stops at Options::visits_per_vertex_max. [BossenHeckbert1996]
  kPaper,
};

/// The smoothing function f(d) of eq. 2 and its step. [BossenHeckbert1996, fig. 6]
enum class Smoothing {
  kPliant,        ///< (1 - d^4) exp(-d^4): attracts beyond d = 1, repels below. The paper's choice.
  kLaplacian,     ///< -d with step 1/n: to the centroid of the neighbours.
  kLennardJones,  ///< d^-13 - d^-7, limited near 0 where it is unstable.
  kBubble,        ///< The cubic of bubble meshing, 0 beyond d = 1.5. [ShimadaGossard1995]
};

/// What the loop may change. Restrictions serve figure 7 and solvers that must keep connectivity.
struct Permissions {
  bool insert = true;   ///< Insert and delete nodes.
  bool swap = true;     ///< Swap edges.
  bool move = true;     ///< Move nodes.
  bool surface = true;  ///< Split constrained edges; move and delete the vertices on them.

  friend bool operator==(const Permissions&, const Permissions&) = default;
};

/// How a session's mesh is kept. Defaults are for everyone; the notes say who should change them.
struct Options {
  Variant variant = Variant::kNested;
  Smoothing smoothing = Smoothing::kPliant;
  Permissions permissions = {};

  /// Seed of random picking; only Variant::kPaper draws. Any value.
  std::uint64_t seed = 1;

  /// Step alpha of eq. 2, in (0, 1]; 0 means 0.3, and the paper's 0.2 for kPaper. Larger
  /// converges in fewer visits and then becomes restless. For experiments.
  double step = 0;

  /// A node whose last step was shorter than this, in metric length, goes to sleep. Smaller gives
  /// better meshes for more visits: 0.02 costs twice the visits of 0.05. In (0, 1); 0 means 0.03,
  /// and 0.02 for kPaper (the paper gives none).
  double speed_threshold = 0;

  /// Cooling begins at this age (visits within one update) and the node rests at `age_max`. Below
  /// 30/80 a first build can stop before it has refined enough. 1 <= age_cooling < age_max <= 250.
  std::int32_t age_cooling = 30;
  std::int32_t age_max = 80;

  /// An update wakes nodes at most this many edges away from what it changed. Larger lets quality
  /// spread further and costs more; 8 bounds the reach at no measurable loss. 1..250.
  std::int32_t hops_max = 8;

  /// A new tensor that differs from a node's by less than this share leaves the node asleep, and
  /// its metric as it was. In [0, 1]; 0 wakes on any change.
  double metric_tolerance = 0.05;

  /// How far an update may move the boundary, in domain units, to get rid of corners that it does
  /// not need: those that a solver made by moving nodes of a side, or gave, and which are closer
  /// together than the metric asks for. SoftenBoundary (core/motion/soften.h) takes such corners
  /// back. Larger lets longer stretches follow the metric; 0, the default, keeps every given point
  /// for ever. For solvers that move their nodes along with the material. >= 0.
  double boundary_tolerance = 0;

  /// No update may take the mesh beyond this many vertices; insertions are refused there, and the
  /// report says so. 3..100,000,000.
  std::int32_t vertices_max = 10'000'000;

  /// kPaper gives up after this many visits per vertex of one update. >= 1.
  std::int32_t visits_per_vertex_max = 400;

  friend bool operator==(const Options&, const Options&) = default;
};

/// How long one call of Remesher::Step may run. Any prefix of the loop leaves a valid mesh.
struct Budget {
  /// At most this many visits. > 0.
  std::int64_t visits_max = INT64_MAX;
  /// Asked every few visits, and within longer work, if given; a yes ends the step. Not owned.
  const StopSignal* stop = nullptr;
};

}  // namespace pliant
