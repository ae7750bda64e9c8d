"""Times two programs alternately, for scripts that measure the cost of a feature."""
import math
import random
import statistics
import sys


def cost_of(pairs, seconds):
    """Times pairs of runs with and without a feature, in random order within each pair. `seconds(which)` times a run
    with the feature (True) or without it (False). Returns the median time without the feature, the mean logarithm of
    the ratio with : without, and the standard error of this mean."""
    ratios, times = [], []
    for i in range(pairs):
        order = [True, False]
        random.Random(i).shuffle(order)
        pair = {which: seconds(which) for which in order}
        times.append(pair[False])
        ratios.append(math.log(pair[True] / pair[False]))
    return statistics.median(times), statistics.mean(ratios), statistics.stdev(ratios) / math.sqrt(len(ratios))


def finish(lines, output, complaint):
    """Prints the table, writes it to `output` if given, and exits with `complaint` if there is one."""
    text = "\n".join(lines) + "\n"
    print(text)
    if output:
        output.write_text(text)
    if complaint:
        sys.exit(complaint)
