"""Voxel maps as folders of partitions: cubes of space, each a Parquet file, read on demand."""
