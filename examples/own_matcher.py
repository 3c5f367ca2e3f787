"""A matcher of one's own, judged beside recon's: python own_matcher.py PAIR_DIR."""

import sys
from pathlib import Path

from own_matchers import block_matching

import recon

recon.register("matchers", "blocks", recon.ImageMatcher(match=block_matching))
job = recon.Job(
    kind="evaluate", inputs=(Path(sys.argv[1]),), arguments={"matchers": ("phase", "blocks")}
)
for row in recon.execute(job)["pairs"]:
    print(f"{row['matcher']}: {row['num_matches']} matches, {row['success_all']:.1f} % right")
