"""Meshes of a scene: faces refer to existing vertices."""

import pytest

from recon.errors import InputError
from recon.world.meshes import read_mesh


@pytest.mark.parametrize("corner", [99999999, -7])
def test_face_with_a_missing_vertex_is_rejected(tmp_path, corner):
    xyz = "".join(f"property float {axis}\n" for axis in "xyz")
    (tmp_path / "a.ply").write_text(
        f"ply\nformat ascii 1.0\nelement vertex 3\n{xyz}element face 1\n"
        f"property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 {corner}\n"
    )
    with pytest.raises(InputError, match=r"a face uses vertices -?\d+ to \d+, but there are 3"):
        read_mesh(tmp_path / "a.ply")
