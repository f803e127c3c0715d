"""The page that shows all pictures of a run."""

import html

_STYLE = """body { font: 16px/1.5 sans-serif; margin: 2em auto; max-width: 76em; color: #222428; }
img { max-width: 100%; max-height: 60em; } table { border-collapse: collapse; }
td, th { padding: .15em .8em; text-align: right; border-bottom: 1px solid #ddd; }
td:first-child, th:first-child { text-align: left; }"""


def write_index(path, figures):
    """Writes one HTML page with each figure's numbers and pictures."""
    parts = [f"<!DOCTYPE html>\n<html lang=en><meta charset=utf-8><title>Pliant: figures</title>\n"
             f"<style>{_STYLE}</style>\n<h1>Figures of the pliant method</h1>\n"
             "<p>F. Bossen, P. Heckbert: A pliant method for anisotropic mesh generation, 1996, "
             "by this server. Click a picture for its SVG; meshes are in <a "
             "href=meshes>meshes/</a>.</p>"]
    for figure in figures:
        parts.append(f"<h2>{html.escape(figure.title)}</h2>\n<p>{html.escape(figure.text)}</p>")
        parts.append(_table(figure.rows))
        for name in figure.pictures:
            parts.append(f"<p><a href=pictures/{name}.svg><img src=pictures/{name}.png "
                         f"alt={name}></a></p>")
    path.write_text("\n".join(parts) + "\n</html>\n")


def _table(rows):
    lines = ["<table><tr><th>mesh<th>nodes<th>paper's<th>seconds<th>mean Q"
             "<th>edges in [0.8, 1.25]"]
    for row in rows:
        paper = f"{row.paper_node_count:,}" if row.paper_node_count else ""
        lines.append(f"<tr><td>{html.escape(row.what)}<td>{row.node_count:,}<td>{paper}"
                     f"<td>{row.seconds:.3f}<td>{row.q_mean:.3f}<td>{100 * row.share_125:.1f} %")
    return "\n".join(lines) + "</table>"
