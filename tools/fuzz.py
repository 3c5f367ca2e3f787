"""Feed readers mutations of sound files: python tools/fuzz.py READER... [-n N | --long] [--seed S].

READER is an ending or a kind of document, or `all`; what fails is kept in the folder `fuzz/` and
named with its seed. Memory is bounded at 6 GB. The long mode gives 10,000 mutations to a reader
that takes under 5 ms for one, and 1,000 to a slower one.
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
    """Fuzz, print a line a reader, and return 1 where anything failed."""
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
    """Number of mutations of the long mode, by the time that some take."""
    began = time.process_time()
    for number in range(NUM_TIMED):
        fault(reader, mutated(reader.content, np.random.default_rng(number)), folder)
    is_fast = time.process_time() - began < NUM_TIMED * FAST_S
    return NUM_FAST if is_fast else NUM_SLOW


def fuzz(reader: Reader, num: int, seed: int, folder: Path) -> int:
    """Number of the mutations that a reader takes badly; those are kept."""
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
