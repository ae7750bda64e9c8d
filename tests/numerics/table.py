#!/usr/bin/env python3
"""Compares the numerics tests' comparisons with those in a CSV table, or writes the table.

    table.py ROWS TABLE [--write]

ROWS holds one JSON object per line, as tests/numerics/closed_form.h writes them. Standard output
gets a summary and the worst comparison of each test. Without --write, TABLE must hold the same
comparisons (case and what) as ROWS, and each of them as many times. Figures are not compared, since
a machine with another math library may give other last digits. --write replaces TABLE.

The exit code is 1 if a comparison fails, if TABLE lacks a comparison, or if TABLE has one that no
test makes. Otherwise it is 0.
"""
import argparse
import collections
import csv
import json
import math
import pathlib
import re
import signal
import sys

# A spread below this share of the value comes from rounding to float, not from chance.
ROUNDING = 1e-7


def case_key(case):
    """Returns a sort key. The catalogue's cases come first, by number, and then our own: 2, 12, E1."""
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


def allowance_used(row):
    """Returns the deviation divided by the allowed deviation. The comparison fails above 1."""
    if any(not isinstance(row[k], (int, float)) for k in ("measured", "exact", "standard_error")):
        return math.inf  # JSON writes a NaN as null
    allowed = 5 * row["standard_error"] + row["tolerance"]
    return abs(deviation(row)) / allowed if allowed > 0 else (0.0 if deviation(row) == 0 else math.inf)


def verdict(row):
    if row["passes"]:
        return "mended" if row["reason"] else "pass"
    return "known failure" if row["reason"] else "FAIL"


def full_verdict(row):
    return f"known failure: {row['reason']}" if verdict(row) == "known failure" else verdict(row)


def number(value, digits):
    return "NaN" if value is None else f"{value:.{digits}g}"


def deviation_in_errors(row):
    if row["measured"] is None:
        return "NaN"
    if not has_spread(row):
        return "exact" if deviation(row) == 0 else "-"
    return f"{deviation(row) / row['standard_error']:+.2f}"


def escape_markdown(text):
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")


def cells(*columns):
    return "| " + " | ".join(columns) + " |"


HEADER = ["case", "test", "what", "exact", "measured", "standard error", "deviation / SE", "tolerance", "verdict",
          "reason"]


def figures(row):
    tolerance = row["tolerance"]
    return [number(row["exact"], 7), number(row["measured"], 7),
            number(row["standard_error"], 2) if row["standard_error"] else "0", deviation_in_errors(row),
            number(tolerance, 2) if tolerance else "0"]


def summary(rows):
    verdicts = collections.Counter(verdict(r) for r in rows)
    known = verdicts["known failure"]
    others = sum(verdicts.values()) - verdicts["pass"] - known
    worst = max((r for r in rows if verdict(r) == "pass"), key=allowance_used)
    lines = [
        f"{len({r['case'] for r in rows})} cases, {len(rows)} comparisons: {verdicts['pass']} pass, "
        f"{known} known failure{'' if known == 1 else 's'}, {others} fail. The closest call among the "
        f"passes is case {worst['case']}, {escape_markdown(worst['what'])}: {allowance_used(worst):.0%} of what it is allowed.",
        "",
        "Allowed is 5 standard errors, which a right answer exceeds once in 1.7 million comparisons (two-sided "
        f"normal; about {len(rows) / 1.74e6:.1g} false alarms expected in this table), plus the tolerance, which is "
        "for what is approximate by construction.",
    ]
    honest = [r for r in rows if has_spread(r) and r["tolerance"] <= r["standard_error"] / 4 and r["passes"]]
    if honest:
        deviations = [abs(deviation(r)) / r["standard_error"] for r in honest]
        rms = math.sqrt(sum(z * z for z in deviations) / len(deviations))
        beyond = ", ".join(f"{sum(z > k for z in deviations) / len(deviations):.1%} beyond {k} (normal: {p})"
                           for k, p in ((1, "31.7%"), (2, "4.6%"), (3, "0.3%")))
        lines += [
            "",
            f"Are the standard errors honest? Of the {len(honest)} comparisons whose tolerance is at most a quarter of "
            f"the standard error, so that chance alone decides: {beyond}; the largest is {max(deviations):.2f}, the root mean "
            f"square {rms:.2f} (normal: 1).",
        ]
    return lines


def worst_of_each_test(rows):
    groups = collections.defaultdict(list)
    for row in rows:
        groups[row["case"], row["test"]].append(row)
    lines = ["", "The worst comparison of each test:", "",
             cells("case", "test", "comparisons", "worst of them", *HEADER[3:-1]),
             cells(*["---"] * 10)]
    for (case, test), members in groups.items():
        worst = max(members, key=allowance_used)
        bad = [full_verdict(r) for r in members if verdict(r) != "pass"]
        verdicts = "pass" if not bad else bad[0] if len(bad) == 1 else f"{len(bad)} x {bad[0]}"
        lines.append(cells(case, f"`{test}`", str(len(members)), escape_markdown(worst["what"]),
                           *figures(worst), escape_markdown(verdicts)))
    return lines


def table_rows(rows):
    return [[row["case"], row["test"], row["what"], *figures(row), verdict(row), row["reason"]] for row in rows]


def write_table(path, rows):
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([HEADER, *table_rows(rows)])


def names_in(path):
    """Counts how often each comparison (case, what) occurs in a table."""
    if not path.exists():
        sys.exit(f"{path}: no such file; run ci/numerics.sh --write")
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames != HEADER:
            sys.exit(f"{path}: the first line is not '{','.join(HEADER)}'")
        return collections.Counter((row["case"], row["what"]) for row in reader)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("rows", type=pathlib.Path)
    parser.add_argument("table", type=pathlib.Path)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()

    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # so that `| head` is no error
    rows = sorted((json.loads(line) for line in arguments.rows.read_text().splitlines()), key=row_key)
    if not rows:
        sys.exit(f"{arguments.rows}: no comparison was recorded")
    print("\n".join(summary(rows) + worst_of_each_test(rows)))

    bad = [r for r in rows if verdict(r) in ("FAIL", "mended")]
    for row in bad:
        print(f"case {row['case']}, {row['what']} ({row['test']}): {verdict(row)}, measured {row['measured']}, "
              f"exact {row['exact']}, allowed {5 * row['standard_error'] + row['tolerance']:.3g}", file=sys.stderr)
    if arguments.write:
        write_table(arguments.table, rows)
        return 1 if bad else 0

    now, then = collections.Counter((r["case"], r["what"]) for r in rows), names_in(arguments.table)
    for (case, what), count in ((now - then) + (then - now)).items():
        where = "not in" if (case, what) in now - then else "only in"
        print(f"case {case}, {what}: {where} {arguments.table}"
              f"{f' ({count} times)' if count > 1 else ''}; run ci/numerics.sh --write", file=sys.stderr)
    return 1 if bad or now != then else 0


if __name__ == "__main__":
    sys.exit(main())
