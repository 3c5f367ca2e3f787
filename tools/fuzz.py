"""Fuzz readers with mutated files: python tools/fuzz.py READER... [-n N | --long] [--seed S].

READER is a file extension or a kind of document, or `all`; failing files are kept in `fuzz/` and
named by their seed. Memory is limited to 6 GB. The long mode uses 10,000 mutations for a reader
that takes under 5 ms each, and 1,000 for a slower one.
"""

import argparse
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.fuzzing import Reader, fault, mutated, readers

MEMORY = 6 << 30
FAST_S = 0.005
NUM_FAST, NUM_SLOW, NUM_TIMED = 10_000, 1_000, 30


def main() -> int:
    """Fuzz, print one line per reader, and return 1 if anything failed."""
    with tempfile.TemporaryDirectory() as folder:
        found = readers(Path(folder))
        parser = argparse.ArgumentParser(description=__doc__)
        parser.add_argument("reader", nargs="+", choices=["all", *found])
        parser.add_argument("-n", type=int, default=1000, help="mutations per reader")
        parser.add_argument("--long", action="store_true", help="as many as its speed allows")
        parser.add_argument("--seed", type=int, default=0)
        given = parser.parse_args()
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        names = list(found) if "all" in given.reader else given.reader
        num_faults = 0
        for name in names:
            num = long_number(found[name], Path(folder)) if given.long else given.n
            num_faults += fuzz(found[name], num, given.seed, Path(folder))
        return int(num_faults > 0)


def long_number(reader: Reader, folder: Path) -> int:
    """Choose the number of mutations of the long mode by timing a few."""
    began = time.process_time()
    for number in range(NUM_TIMED):
        fault(reader, mutated(reader.content, np.random.default_rng(number)), folder)
    is_fast = time.process_time() - began < NUM_TIMED * FAST_S
    return NUM_FAST if is_fast else NUM_SLOW


def fuzz(reader: Reader, num: int, seed: int, folder: Path) -> int:
    """Count the mutations on which a reader fails, and keep them."""
    began = time.perf_counter()
    num_faults = 0
    for number in range(num):
        content = mutated(reader.content, np.random.default_rng([seed, number]))
        wrong = fault(reader, content, folder)
        if wrong:
            num_faults += 1
            kept = Path("fuzz") / f"{seed}-{number}{reader.name}"
            kept.parent.mkdir(exist_ok=True)
            kept.write_bytes(content)
            print(f"{kept}: {wrong}")
    seconds = time.perf_counter() - began
    print(f"{reader.name:16} {num} mutations, {num_faults} faults, {seconds:.1f} s", flush=True)
    return num_faults


if __name__ == "__main__":
    sys.exit(main())
