"""The plot of farm_growth.py: an SVG line chart with two logarithmic axes, without any library."""
import math
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 900, 560
LEFT, RIGHT, TOP, BOTTOM = 82, 24, 84, 66
COLORS = ("#0b62a4", "#c2500a", "#2f7d32", "#7b3fa0")  # one for each scene
INK, GRID = "#222222", "#dddddd"
MIN_X, MAX_X = 1, 1000


class Paper:
    """Maps nodes and seconds to points of the picture."""

    def __init__(self, min_y, max_y):
        self.low, self.high = math.log10(min_y), math.log10(max_y)

    def x(self, nodes):
        return LEFT + (WIDTH - LEFT - RIGHT) * math.log(nodes / MIN_X) / math.log(MAX_X / MIN_X)

    def y(self, seconds):
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (math.log10(seconds) - self.low) / (self.high - self.low)


def text(x, y, words, anchor="start", size=14, more=""):
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" font-size="{size}" {more}>{escape(words)}</text>'


def line(x0, y0, x1, y1, style):
    return f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" {style}/>'


def ring(x, y, color):
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="white" stroke="{color}" stroke-width="2.5"/>'


def seconds_name(exponent):
    return f"{10**exponent:,} s" if exponent >= 0 else f"{10.0**exponent:g} s"


def axes(paper):
    for exponent in range(round(paper.low), round(paper.high) + 1):
        y = paper.y(10.0**exponent)
        yield line(LEFT, y, WIDTH - RIGHT, y, f'stroke="{GRID}"')
        yield text(LEFT - 8, y + 5, seconds_name(exponent), "end")
    for nodes in (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000):
        x = paper.x(nodes)
        yield line(x, TOP, x, HEIGHT - BOTTOM, f'stroke="{GRID}"')
        yield text(x, HEIGHT - BOTTOM + 20, f"{nodes:,}", "middle")
    yield text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 16, "nodes", "middle", 15)
    middle = (TOP + HEIGHT - BOTTOM) / 2
    yield text(20, middle, "time of the frame", "middle", 15, f'transform="rotate(-90 20 {middle:.0f})"')


def legend_height(rows):
    return 22 * len(rows) + 14


def legend(rows, x, y):
    """Draws the rows, which are pairs (function that draws at a point, words), below one another."""
    height = legend_height(rows)
    yield f'<rect x="{x}" y="{y}" width="286" height="{height}" fill="white" stroke="{GRID}"/>'
    for i, (drawing, words) in enumerate(rows):
        at = y + 22 * i + 18
        yield drawing(x + 10, at)
        yield text(x + 60, at + 5, words)


def plot(title, subtitle, curves):
    """Returns the SVG for curves (name, solid, [(nodes, seconds)], marked point or None). The two curves
    of a scene are adjacent."""
    values = [seconds for _, _, points, _ in curves for _, seconds in points]
    paper = Paper(10.0 ** math.floor(math.log10(min(values))), 10.0 ** math.ceil(math.log10(max(values))))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
             f'font-family="system-ui, sans-serif" fill="{INK}">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
             text(LEFT, 34, title, size=22, more='font-weight="600"'), text(LEFT, 60, subtitle), *axes(paper)]
    rings, rows = [], []
    for i, (name, solid, points, half) in enumerate(curves):
        color = COLORS[i // 2 % len(COLORS)]
        style = f'fill="none" stroke="{color}" stroke-width="2.5"' + ("" if solid else ' stroke-dasharray="7 5"')
        path = " ".join(f"{paper.x(n):.1f},{paper.y(s):.1f}" for n, s in points)
        parts.append(f'<polyline points="{path}" {style}/>')
        if half:
            rings.append(ring(paper.x(half[0]), paper.y(half[1]), color))
        rows.append((lambda x, y, style=style: line(x, y, x + 40, y, style), name))
    rows.append((lambda x, y: ring(x + 20, y, INK), "from here reading, loading and"))
    rows.append((lambda x, y: "", "merging take more than half"))
    parts += [*rings, *legend(rows, LEFT + 12, HEIGHT - BOTTOM - 12 - legend_height(rows)), "</svg>"]
    return "\n".join(parts) + "\n"
