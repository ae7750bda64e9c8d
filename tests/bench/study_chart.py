#!/usr/bin/env python3
"""Extracts one chart of a study's page as a separate SVG file on white, for a README.

    tests/bench/study_chart.py study/study.html "relmse against time" scenes/gallery/denoised_time.svg --title "..."
"""
import argparse
import pathlib
import re
from xml.sax.saxutils import escape

INK = "#222222"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("chart", help="title of the chart in the page")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--title", help="replaces the title")
    args = parser.parse_args()
    charts = re.findall(r"<svg .*?</svg>", args.page.read_text(), flags=re.DOTALL)
    found = [chart for chart in charts if f'aria-label="{escape(args.chart)}"' in chart]
    if len(found) != 1:
        raise SystemExit(f"{args.page}: expected one chart '{args.chart}', found {len(found)}")
    chart = found[0].replace("currentColor", INK).replace(' style="color-scheme:light dark"', ' width="840"', 1)
    if args.title:
        chart = chart.replace(escape(args.chart), escape(args.title))
    page = '<rect width="100%" height="100%" fill="white"/>'
    args.out.write_text(chart.replace(">", f">\n{page}", 1) + "\n")


if __name__ == "__main__":
    main()
