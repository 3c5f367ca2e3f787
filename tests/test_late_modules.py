"""Modules that are loaded late are whole once they are used."""

import subprocess
import sys

CODE = """
import sys
import numpy
from recon.libraries import load_late
load_late("numpy.f2py")
import scipy.spatial
assert "numpy.f2py.crackfortran" not in sys.modules
assert numpy.f2py.get_include()
assert "numpy.f2py.crackfortran" in sys.modules
"""


def test_late_module_is_loaded_by_its_first_use_only():
    subprocess.run([sys.executable, "-c", CODE], check=True)
    # Without it, SciPy loads the module, or there is nothing to be saved.
    plain = 'import sys, scipy.spatial; assert "numpy.f2py.crackfortran" in sys.modules'
    subprocess.run([sys.executable, "-c", plain], check=True)
