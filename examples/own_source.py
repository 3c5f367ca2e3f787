"""Explore your own source of pairs: python own_source.py SCENE NUM_PAIRS."""

import sys
from dataclasses import replace

import recon


class Dusk:
    def __init__(self, scene: str) -> None:
        self.world = recon.World.from_file(scene)  # or connect to your robot

    def start(self) -> recon.View:
        return self.world.start()

    def take(self, view: recon.View) -> recon.StereoPair:
        pair = self.world.take(view)
        return replace(pair, left=pair.left // 2, right=pair.right // 2)


done = recon.explore(Dusk(sys.argv[1]), max_pairs=int(sys.argv[2]))
print(done.reconstruction, done.stop_reason)
