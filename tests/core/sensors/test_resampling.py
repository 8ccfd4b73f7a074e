"""Sound at another rate: scipy's filter, without what scipy.signal takes to import."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.signal import resample_poly

from core.sensors.resampling import resampled

FRAMES = "import numpy as np; from core.sensors.resampling import resampled; resampled(np.ones(99), 22050, 16000)"


@pytest.mark.parametrize(
    ("rate", "wanted"), [(22_050, 16_000), (48_000, 16_000), (44_100, 16_000), (8_000, 16_000), (19, 20), (10, 9)]
)
@pytest.mark.parametrize("shape", [(3_001,), (1_500, 4), (1,), (0,)])
def test_the_samples_are_those_of_scipy(rate: int, wanted: int, shape: tuple[int, ...]) -> None:
    samples = np.random.default_rng(3).normal(size=shape)
    np.testing.assert_allclose(resampled(samples, rate, wanted), resample_poly(samples, wanted, rate), atol=1e-12)


def test_a_process_that_resamples_does_without_scipy() -> None:
    code = f"import sys; {FRAMES}; print([name for name in sys.modules if name.startswith('scipy')])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"
