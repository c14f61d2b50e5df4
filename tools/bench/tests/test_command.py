"""`python -m tools.bench` needs what the measurement that was asked for needs, and no more."""

from __future__ import annotations

import subprocess
import sys

import pytest
from scipy.stats import chi2

from tools.bench.__main__ import BENCHES, main
from tools.bench.vision.tables import chi_squared

# Packages that `make setup` does not install.
DEVELOPMENT = ("scipy", "sklearn", "skl2onnx", "onnx", "toppra", "pymavlink", "psutil", "ompl")

WITHOUT_THEM = f"""
import sys
sys.modules.update(dict.fromkeys({DEVELOPMENT}))
from tools.bench.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


def bench_after_setup(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", WITHOUT_THEM, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", [name for name in BENCHES if name not in ("protocol", "detector")])
def test_help_works_after_setup_alone(name: str) -> None:
    done = bench_after_setup(name, "--help")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usage:")


def test_what_is_missing_is_said_in_one_line() -> None:
    done = bench_after_setup("protocol", "--help")
    assert done.returncode == 3
    assert done.stderr == "the measurement `protocol` needs the Python package pymavlink: run 'make setup-dev'\n"


def test_an_unknown_measurement_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["speed"]) == 2
    assert "{" + ",".join(BENCHES) + "}" in capsys.readouterr().err


@pytest.mark.parametrize("freedom", [12, 24, 60, 300])
@pytest.mark.parametrize("probability", [0.025, 0.975])
def test_bounds_of_the_nees_are_those_of_the_distribution(freedom: int, probability: float) -> None:
    assert chi_squared(probability, freedom) == pytest.approx(float(chi2.ppf(probability, freedom)), rel=5e-3)
