"""Headers of VTK files that claim what they do not hold."""

import struct

import numpy as np
import pytest

from recon.exports import read
from tests.exports.rejected import assert_rejected

BLOCK = (
    b'<VTKFile type="ImageData" version="1.0" header_type="UInt64"%s><ImageData '
    b'WholeExtent="0 9 0 9 0 9" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 9 0 9 0 9">'
    b'<PointData><DataArray type="Float64" Name="a" format="appended" offset="0"/></PointData>'
    b'</Piece></ImageData><AppendedData encoding="raw">_%s</AppendedData></VTKFile>'
)


@pytest.mark.parametrize(
    ("packing", "head", "message"),
    [
        (b' compressor="vtkZLibDataCompressor"', (1, 2**40, 2**40), "GB of memory"),
        (b' compressor="vtkZLibDataCompressor"', (2**40, 8, 8), "claims 1099511627776 blocks"),
        (b"", (2**40, 0, 0), "claims 1099511627776 blocks or bytes"),
    ],
)
def test_vtk_array_with_a_false_size_is_rejected(tmp_path, packing, head, message):
    """VTK itself would abort the process."""
    content = struct.pack("<3Q", *head) + bytes(20)
    (tmp_path / "a.vti").write_bytes(BLOCK % (packing, content))
    assert_rejected(tmp_path / "a.vti", message)


@pytest.mark.parametrize("options", [{"binary": True}, {"binary": False}])
def test_valid_vtk_images_are_read(tmp_path, options):
    import pyvista

    block = pyvista.ImageData(dimensions=(9, 9, 9))
    block["a"] = np.arange(1.0, 730.0)
    block.save(tmp_path / "a.vti", **options)
    assert len(read(tmp_path / "a.vti")) == 729
