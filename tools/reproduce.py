"""Every figure and table of the thesis's own results, beside recon's."""

import argparse
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(Path(__file__).parent))

from reproduction import disparity, features, maps, probability, simulator  # noqa: E402
from reproduction.entry import Absent, Entry, Result  # noqa: E402
from reproduction.page import write_page  # noqa: E402


def order(entry: Entry) -> tuple[int, float]:
    """Figures by number, then tables."""
    kind, _, rest = entry.name.partition(" ")
    return (0 if kind == "figure" else 1, float(rest) if rest.isdecimal() else 1e9)


def made(entry: Entry) -> tuple[Entry, Result | str, float]:
    """Compute an entry; return it with its result or the reason for its absence, and its time."""
    began = time.perf_counter()
    try:
        result: Result | str = entry.make()
    except Absent as absent:
        result = str(absent)
    seconds = time.perf_counter() - began
    state = result if isinstance(result, str) else "done"
    print(f"{entry.name:24} {seconds:6.1f} s  {state}", flush=True)
    return entry, result, seconds


def main() -> None:
    """Make the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "site" / "thesis")
    parser.add_argument("--only", action="append", help="Name of an entry, as 'figure 12'.")
    given = parser.parse_args()
    parts = (features, disparity, probability, simulator, maps)
    entries = sorted((entry for part in parts for entry in part.entries()), key=order)
    chosen = [one for one in entries if not given.only or one.name in given.only]
    print(write_page([made(entry) for entry in chosen], given.output))


if __name__ == "__main__":
    main()
