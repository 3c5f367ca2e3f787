"""Threads: how many processors a batch may use."""

import os


def num_processors() -> int:
    """Processors this process may use: Slurm's allowance, else those it is bound to."""
    bound = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    allowed = os.environ.get("SLURM_CPUS_PER_TASK", "")
    return min(bound, int(allowed)) if allowed.isdecimal() and int(allowed) else bound
