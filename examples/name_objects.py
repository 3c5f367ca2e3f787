"""Name the objects of a cloud: python name_objects.py CLOUD.ply [CATALOGUE.toml]."""

import sys

import recon

cloud = recon.read(sys.argv[1])
if not isinstance(cloud, recon.PointCloud):
    sys.exit(f"{sys.argv[1]} holds {cloud}, but a cloud is needed")
found = recon.recognise(cloud, catalogue=sys.argv[2] if sys.argv[2:] else None)
for one in found.objects:
    share = (found.label == one.id).mean()
    print(f"{one.label} at {one.centre.round(2)}, size {one.size.round(2)}, {share:.0%} of points")
