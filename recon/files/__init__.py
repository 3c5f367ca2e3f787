"""Files: written atomically; read only if regular and within limits."""

from recon.files.atomic import PathLike, atomic_path, remove_temporaries
from recon.files.limits import (
    Limits,
    check_memory,
    check_name,
    check_regular,
    check_target,
    may_read,
    memory_limit,
    outside_allowed,
)

__all__ = [
    "Limits",
    "PathLike",
    "atomic_path",
    "check_memory",
    "check_name",
    "check_regular",
    "check_target",
    "may_read",
    "memory_limit",
    "outside_allowed",
    "remove_temporaries",
]
