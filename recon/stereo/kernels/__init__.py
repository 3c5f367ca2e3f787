"""Kernels: the vector type, memory, sorting and angles of the inner loops."""
