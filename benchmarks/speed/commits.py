"""Is one installation slower than another? Both in turn on one machine, so that only ratios count.

    python benchmarks/speed/commits.py OLD_PYTHON NEW_PYTHON [--small]

Each argument is a Python with a weftex. Every job runs in a process of its own, in turn with the
other's; medians of processor time, of five. Prints Markdown.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess

JOBS = {
    "patch-sampling 2048": "s, 2048, method='patch-sampling'",
    "quilting 2048": "s, 2048, method='quilting'",
    "graphcut 512": "s, 512, method='graphcut'",
    "near-regular 512": "b, 512, method='near-regular'",
    "efros-leung 48": "s, 48, method='efros-leung'",
    "wei-levoy 128": "s, 128, method='wei-levoy'",
    "ashikhmin 256": "s, 256, method='ashikhmin'",
    "exact-matching 128": "s, 128, method='exact-matching'",
    "refinement 128": "s, 128, method='refinement'",
    "auto 512": "b, 512",
}
_CHILD = """
import time
import weftex
s = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:128, :128].copy())
b = weftex.load_exemplar("sample:bricks")
start = time.process_time()
weftex.synthesize({}, seed=7, threads=1).image
print(time.process_time() - start)
"""


def seconds(python: str, job: str) -> float:
    """Processor time of one job."""
    command = [python, "-c", _CHILD.format(job)]
    return float(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("pythons", nargs=2, metavar="PYTHON")
    parser.add_argument("--small", action="store_true", help="one job, once: it runs")
    args = parser.parse_args()
    jobs = dict([*JOBS.items()][:1]) if args.small else JOBS
    print("| job | before | after | ratio |\n| --- | --- | --- | --- |")
    for name, job in jobs.items():
        took: list[list[float]] = [[], []]
        for _ in range(1 if args.small else 5):
            for times, python in zip(took, args.pythons, strict=True):
                times.append(seconds(python, job))
        old, new = map(statistics.median, took)
        flag = " **slower**" if new > 1.15 * old else ""
        print(f"| {name} | {old:.3f} s | {new:.3f} s | {new / old:.2f}{flag} |", flush=True)


if __name__ == "__main__":
    main()
