"""Modules that are loaded late are whole once they are used, and compiled ahead if wanted."""

import os
import subprocess
import sys

from recon.runs.compile import compile_modules

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


def test_workers_of_a_batch_spare_them_too():
    code = 'import sys, recon.batch.loaded; assert "numpy.f2py.crackfortran" not in sys.modules'
    subprocess.run([sys.executable, "-c", code], check=True)


def test_bytecode_is_written_where_python_writes_none(tmp_path):
    (tmp_path / "module.py").write_text("VALUE = 1\n")
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(tmp_path)}
    compile_modules(tmp_path)
    code = "import module, os; assert os.path.exists(module.__cached__)"
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
