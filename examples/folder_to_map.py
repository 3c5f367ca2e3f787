"""Reconstruct a recording into a map file: python folder_to_map.py SEQUENCE MAP.npz."""

import sys

import recon

mapper = recon.Mapper(recon.settings_for(sys.argv[1], quality="fast"))
for pair in recon.open_sequence(sys.argv[1]):
    for step in mapper.process(pair):
        print(step)
mapper.finish()
done = mapper.reconstruction()
done.map.save(sys.argv[2])
print(done)
