"""The check that a file is refused in one line."""

import pytest

from recon.errors import InputError
from recon.exports import read


def assert_rejected(path, message):
    with pytest.raises(InputError, match=message) as error:
        read(path)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)
