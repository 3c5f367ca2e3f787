"""Reconstruct a recording into a map file: python folder_to_map.py SEQUENCE MAP.npz."""

import sys

import recon

done = recon.reconstruct(sys.argv[1], quality="fast")
done.map.save(sys.argv[2])
print(done)
print(f"the camera went {done.trajectory.length:.2f} units, to {done.trajectory.positions[-1]}")
