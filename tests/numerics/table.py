#!/usr/bin/env python3
"""Makes the table of comparisons from the rows that the numerics tests recorded.

    table.py ROWS PAGE [--write]

ROWS has one JSON object per line, written by tests/numerics/closed_form.h. PAGE contains the table
between two marker comments. Without --write the table goes to standard output, and PAGE must list
the same comparisons (case and what). Figures are not checked, since another math library may change
their last digits.

Exit code: 0, or 1 when a comparison fails, or when PAGE lacks a comparison or lists an obsolete one.
"""
import argparse
import collections
import json
import math
import pathlib
import re
import signal
import sys

BEGIN = "<!-- made by ci/numerics.sh --write: begin -->"
END = "<!-- made by ci/numerics.sh --write: end -->"

# A spread below this share of the value is float rounding, not noise.
ROUNDING = 1e-7


def case_key(case):
    """Sorts catalogue cases by number, then our own: 2 before 12 before E1."""
    return [(0, int(p)) if p.isdigit() else (1, p) for p in re.findall(r"\d+|\D+", case)]


def row_key(row):
    natural = [(0, float(p)) if re.fullmatch(r"\d*\.?\d+", p) else (1, p)
               for p in re.findall(r"\d*\.?\d+|\D+", row["what"])]
    keys = case_key(row["case"])
    return (keys[0][0] == 1, keys, row["test"], natural)


def has_spread(row):
    return row["standard_error"] > ROUNDING * abs(row["exact"])


def deviation(row):
    return row["measured"] - row["exact"]


def load(row):
    """Deviation as a share of the allowed one: above 1 the comparison fails."""
    if any(not isinstance(row[k], (int, float)) for k in ("measured", "exact", "standard_error")):
        return math.inf  # JSON writes a NaN as null
    allowed = 5 * row["standard_error"] + row["tolerance"]
    return abs(deviation(row)) / allowed if allowed > 0 else (0.0 if deviation(row) == 0 else math.inf)


def verdict(row):
    if row["passes"]:
        return "mended" if row["reason"] else "pass"
    return "known failure: " + row["reason"] if row["reason"] else "FAIL"


def number(value, digits):
    return "NaN" if value is None else f"{value:.{digits}g}"


def errors_off(row):
    if row["measured"] is None:
        return "NaN"
    if not has_spread(row):
        return "exact" if deviation(row) == 0 else "-"
    return f"{deviation(row) / row['standard_error']:+.2f}"


def escaped(text):
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")


def cells(*columns):
    return "| " + " | ".join(columns) + " |"


HEADER = ["case", "what", "exact", "measured", "standard error", "deviation / SE", "tolerance"]


def comparison_cells(row):
    tolerance = row["tolerance"]
    return [number(row["exact"], 7), number(row["measured"], 7),
            number(row["standard_error"], 2) if row["standard_error"] else "0", errors_off(row),
            number(tolerance, 2) if tolerance else "0"]


def summary(rows):
    verdicts = collections.Counter(verdict(r).split(":")[0] for r in rows)
    known = verdicts["known failure"]
    others = sum(verdicts.values()) - verdicts["pass"] - known
    worst = max((r for r in rows if verdict(r) == "pass"), key=load)
    lines = [
        f"{len({r['case'] for r in rows})} cases, {len(rows)} comparisons: {verdicts['pass']} pass, "
        f"{known} known failure{'' if known == 1 else 's'}, {others} fail. The closest call among the "
        f"passes is case {worst['case']}, {escaped(worst['what'])}: {load(worst):.0%} of what it is allowed.",
        "",
        "Allowed is 5 standard errors, which a right answer exceeds once in 1.7 million comparisons (two-sided "
        f"normal; about {len(rows) / 1.74e6:.1g} false alarms expected in this table), plus the tolerance, which is "
        "for what is approximate by construction.",
    ]
    honest = [r for r in rows if has_spread(r) and r["tolerance"] <= r["standard_error"] / 4 and r["passes"]]
    if honest:
        off = [abs(deviation(r)) / r["standard_error"] for r in honest]
        rms = math.sqrt(sum(z * z for z in off) / len(off))
        beyond = ", ".join(f"{sum(z > k for z in off) / len(off):.1%} beyond {k} (normal: {p})"
                           for k, p in ((1, "31.7%"), (2, "4.6%"), (3, "0.3%")))
        lines += [
            "",
            f"Are the standard errors honest? Of the {len(honest)} comparisons whose tolerance is at most a quarter of "
            f"the standard error, so that chance alone decides: {beyond}; the largest is {max(off):.2f}, the root mean "
            f"square {rms:.2f} (normal: 1).",
        ]
    return lines


def table(rows):
    lines = summary(rows)
    groups = collections.defaultdict(list)
    for row in rows:
        groups[row["case"], row["test"]].append(row)
    lines += ["", "The worst comparison of each test:", "",
              cells("case", "test", "comparisons", "worst of them", *HEADER[2:], "verdict"),
              cells(*["---"] * 10)]
    for (case, test), members in groups.items():
        worst = max(members, key=load)
        bad = [verdict(r) for r in members if verdict(r) != "pass"]
        verdicts = "pass" if not bad else bad[0] if len(bad) == 1 else f"{len(bad)} x {bad[0]}"
        lines.append(cells(case, f"`{test}`", str(len(members)), escaped(worst["what"]),
                           *comparison_cells(worst), escaped(verdicts)))
    lines += ["", "<details><summary>Every comparison</summary>", "",
              cells(*HEADER, "verdict"), cells(*["---"] * 8)]
    for row in rows:
        lines.append(cells(row["case"], escaped(row["what"]), *comparison_cells(row),
                           escaped(verdict(row).split(":")[0])))
    return "\n".join(lines + ["", "</details>"])


def names_in(text):
    """Counts each (case, what) in the full list of a page."""
    full = text.partition("<details>")[2]
    found = collections.Counter()
    for line in full.splitlines():
        columns = re.split(r"(?<!\\) \| ", line.strip().removeprefix("| ").removesuffix(" |"))
        if len(columns) == 8 and columns[0] not in ("case", "---"):
            found[columns[0], columns[1]] += 1
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("rows", type=pathlib.Path)
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()

    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `| head` is no error
    rows = sorted((json.loads(line) for line in arguments.rows.read_text().splitlines()), key=row_key)
    if not rows:
        sys.exit(f"{arguments.rows}: no comparison was recorded")
    made = table(rows)
    page = arguments.page.read_text()
    before, begin, rest = page.partition(BEGIN)
    old, end, after = rest.partition(END)
    if not begin or not end:
        sys.exit(f"{arguments.page}: the lines '{BEGIN}' and '{END}' are missing")

    bad = [r for r in rows if verdict(r) in ("FAIL", "mended")]
    for row in bad:
        print(f"case {row['case']}, {row['what']} ({row['test']}): {verdict(row)}, measured {row['measured']}, "
              f"exact {row['exact']}, allowed {5 * row['standard_error'] + row['tolerance']:.3g}", file=sys.stderr)
    if arguments.write:
        arguments.page.write_text(f"{before}{BEGIN}\n{made}\n{END}{after}")
        return 1 if bad else 0

    print(made)
    now, then = names_in(made), names_in(old)
    for (case, what), count in ((now - then) + (then - now)).items():
        where = "not in" if (case, what) in now - then else "only in"
        print(f"case {case}, {what}: {where} {arguments.page}"
              f"{f' ({count} times)' if count > 1 else ''}; run ci/numerics.sh --write", file=sys.stderr)
    return 1 if bad or now != then else 0


if __name__ == "__main__":
    sys.exit(main())
