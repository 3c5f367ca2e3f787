"""Pass a map to two other libraries: python map_to_open3d_and_pyvista.py MAP.npz OUT.vtp."""

import sys

import recon

voxel_map = recon.VoxelMap.load(sys.argv[1])
cloud = voxel_map.to_open3d(min_count=2)
print(cloud, "with corners", cloud.get_min_bound(), cloud.get_max_bound())
cells = voxel_map.to_pyvista(min_count=2)
cells.save(sys.argv[2])
print(f"{cells.n_points} cells, the fullest of {cells['counts'].max()} points")
# cells.plot(scalars="colours", rgb=True) opens a window.
