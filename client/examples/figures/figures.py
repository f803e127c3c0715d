"""The figures of [BossenHeckbert1996], each as a function of a Workshop that returns a Figure."""

import time

import numpy as np

import formulas
import pliant
from workshop import DATA, Figure, Row, checked, row_of

# What the formulas are scaled by so that the meshes have about as many nodes as the paper's; a
# metric asks for a few more nodes than its integral says, because edges end at the boundary.
GAUSSIAN_COUNT, DIAGONAL_COUNT, SHOCK_COUNT, LETTERS_COUNT = 1000, 861, 8374, 4455


def _tensor(expressions):
    return ["--metric-expr", "; ".join(expressions)]


def smoothing(workshop):
    """Figure 7: smoothing techniques side by side."""
    start, size = DATA / "random.mesh", ["--size", "0.077"]
    panels = [{"mesh": start, "title": "Initial mesh"}]
    cases = [
        ("Laplacian", ["--smoothing", "laplacian", "--no-insert", "--no-swap"]),
        ("Laplace-Delaunay", ["--smoothing", "laplacian", "--no-insert"]),
        ("Pliant, nodes kept", ["--no-insert"]),
        ("Pliant", []),
    ]
    rows = []
    for title, options in cases:
        name = "figure07_" + title.lower().replace(",", "").replace(" ", "_").replace("-", "_")
        report = workshop.remesh(name, start, *size, *options)
        rows.append(row_of("7", title, report))
        panels.append({"mesh": workshop.mesh(name), "title": title})
    workshop.sheet("figure07", {"panels": panels, "columns": 5,
                                "size": 0.42 * workshop.picture_size})
    return Figure(
        "Figure 7: smoothing techniques",
        "One random mesh, smoothed by Laplacian smoothing (no edge is swapped), by Laplacian "
        "smoothing with Delaunay swaps, by the pliant function with swaps but with the nodes "
        "given, which leaves voids, and by the whole method, which fills them.",
        ["figure07"], rows)


def gaussian(workshop):
    """Figure 10: an anisotropic mesh and its metric."""
    metric = _tensor(formulas.gaussian(GAUSSIAN_COUNT))
    source = DATA / "gaussian.poly"
    report = workshop.remesh("figure10", source, *metric)
    workshop.remesh_as_vtu("figure10", source, *metric)
    workshop.plot("figure10a", "figure10", *metric)
    workshop.plot("figure10b", "figure10", *metric, "--ellipses")
    return Figure(
        "Figure 10: a Gaussian",
        "The metric is the Hessian of exp(-r^2/2) with absolute eigenvalues. The second picture "
        "has the ellipse d(p, y) = 1/2 around each node: those of neighbours touch where the mesh "
        "is as wanted.",
        ["figure10a", "figure10b"], [row_of("10", "Gaussian", report)])


def diagonal(workshop):
    """Figure 11: an isotropic mesh and its histograms."""
    size = ["--size", formulas.diagonal(DIAGONAL_COUNT)]
    source = DATA / "square.poly"
    report = workshop.remesh("figure11", source, *size)
    workshop.remesh_as_vtu("figure11", source, *size)
    workshop.plot("figure11", "figure11", *size, "--histograms")
    return Figure(
        "Figure 11: small elements along a diagonal",
        "Most angles are close to 60 degrees, most edges close to the length wanted.",
        ["figure11"], [row_of("11", "diagonal", report, 925)])


def scaling(workshop, count_max, paper_count_max):
    """Figure 12: time against nodes on the Gaussian."""
    counts = [c for e in range(3, 7) for c in (10**e, 3 * 10**e)]
    most = {"nested": count_max, "cooled": min(count_max, 300_000), "paper": paper_count_max}
    lines = {variant: [] for variant in most}
    rows = []
    for variant, points in lines.items():
        for count in [count for count in counts if count <= most[variant]]:
            report = workshop.time(DATA / "gaussian.poly", *_tensor(formulas.gaussian(count)),
                                   "--variant", variant)
            if variant == "paper" and report["stop"] == "visit_limit":
                print(f"figure 12: the paper's loop did not come to rest for {count} nodes")
                break
            rows.append(row_of("12", f"Gaussian, {variant}", report))
            points.append([report["vertex_count"], report["seconds"]["remesh"]])
        if len(points) > 1:
            slope = np.polyfit(*np.log(points).T, 1)[0]
            print(f"   12  {variant}: time grows as nodes^{slope:.2f}", flush=True)
    names = {"nested": "from coarse to fine (default)", "cooled": "cooled loop",
             "paper": "the paper's loop"}
    workshop.sheet("figure12", {"chart": {
        "title": "Time to make the mesh of figure 10", "x_label": "nodes", "y_label": "seconds",
        "series": [{"name": names[v], "points": points} for v, points in lines.items()]}})
    return Figure(
        "Figure 12: time against nodes",
        "From the request to the finished mesh in the client's memory, through the server, on one "
        "core. Both axes are logarithmic; a slope of 1 is time proportional to nodes.",
        ["figure12"], rows)


def shock(workshop):
    """Figures 13 and 14: a shock front with triangles of 100:1, whole and close up."""
    metric = _tensor(formulas.shock(SHOCK_COUNT))
    source = DATA / "square.poly"
    report = workshop.remesh("figure13", source, *metric)
    workshop.remesh_as_vtu("figure13", source, *metric)
    workshop.plot("figure13", "figure13", *metric, "--histograms")
    # The paper zooms in 150 times horizontally and 15 times vertically.
    low, high = (0.5 - 0.5 / 150, 0.5 - 0.5 / 15), (0.5 + 0.5 / 150, 0.5 + 0.5 / 15)
    window = ",".join(f"{v:.8g}" for v in (*low, *high))
    workshop.plot("figure14", "figure13", *metric, "--window", window, "--stretch")
    return Figure(
        "Figures 13 and 14: a shock front",
        "The aspect ratio grows to 100:1 in the middle. The close-up, 150 times wider and 15 times "
        "higher, shows the triangles there.",
        ["figure13", "figure14"], [row_of("13", "shock front", report, 8712)])


def letters(workshop):
    """Figure 15: a session that is told tensors at its nodes, as by a solver."""
    domain = _read_poly(DATA / "letters.poly")
    metric = formulas.Letters(domain.points, LETTERS_COUNT)
    client = pliant.connect(workshop.address)
    began = time.perf_counter()
    # The mesh first knows nothing of the metric. Each update gives it the tensors at its nodes;
    # after five it has nodes wherever the metric has features.
    with client.create_session(domain=domain, metric=pliant.metric.size("0.03")) as session:
        for _ in range(5):
            session.update_metric(metric.tensors(session.mesh.points))
        seconds = time.perf_counter() - began
        quality = session.quality()
        workshop.download("figure15", session.session_id)
        tensors = metric.tensors(session.mesh.points)
        _write_tensors(workshop.mesh("figure15", ".sol"), tensors)
    client.close()
    known = ["--metric", workshop.mesh("figure15", ".sol")]
    workshop.plot("figure15", "figure15", *known)
    workshop.plot("figure15_quality", "figure15", *known, "--histograms", "--quality")
    row = Row("15", "letters", quality.vertex_count, 5523, seconds, quality.q_mean,
              quality.integrated.share_125)
    return Figure(
        "Figure 15: letters",
        "Sizes grow with the distance to the given points, and elements are thin along a sine "
        "curve. The metric came as tensors at the nodes of the present mesh, in five updates of "
        "one session. The second picture has the quality of the triangles.",
        ["figure15", "figure15_quality"], [checked(row)])


def _read_poly(path):
    """A domain in Triangle's format, of the plain kind that lies in data/."""
    lines = [line.split() for line in path.read_text().splitlines()
             if line.strip() and not line.startswith("#")]
    point_count = int(lines[0][0])
    segment_count = int(lines[point_count + 1][0])
    points = np.array([row[1:3] for row in lines[1:point_count + 1]], float)
    segments = np.array(lines[point_count + 2:point_count + 2 + segment_count], np.int32)
    holes = np.array([row[1:3] for row in lines[point_count + 3 + segment_count:]], float)
    return pliant.Domain(points, segments[:, 1:3] - 1, tags=segments[:, 3], holes=holes)


def _write_tensors(path, tensors):
    """Tensors as Medit's .sol."""
    rows = "\n".join(" ".join(repr(float(v)) for v in row) for row in tensors)
    path.write_text("MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n"
                    f"{len(tensors)}\n1 3\n{rows}\nEnd\n")
