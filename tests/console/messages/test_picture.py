"""What viewers get of a picture's quality and of the mount's drift."""

import json
import math

import numpy as np

from console.messages import state as messages
from console.messages.picture import drift, quality
from core.calibration.laser.drift import Drift
from core.perception.image_quality.quality import judge
from core.sensors import Image


def test_a_pictures_quality_is_told_with_its_figures() -> None:
    noise = np.random.default_rng(0).normal(20, 2, (256, 320, 3))
    judged = judge(Image(stamp=0.0, pixels=np.round(noise).astype(np.uint8)))
    told = quality(judged)
    assert told is not None
    assert told.label == "dark"
    assert told.words == judged.words
    sent = json.loads(messages.encode(told))
    assert sent["blur_px"] is None
    assert abs(sent["mean"] - 20) < 0.2
    assert sent["gain"] == round(judged.preparation.gain, 2)
    assert quality(None) is None


def test_a_mounts_drift_is_told_in_radians_and_metres() -> None:
    turn = math.radians(0.8)
    seen = Drift(
        turn=turn,
        turn_sd=0.002,
        shift=-0.0041,
        shift_sd=0.009,
        apparent=turn,
        apparent_sd=0.001,
        pairs=90,
        corners=9,
        alarm=True,
        words="The camera seems to have turned.",
    )
    sent = json.loads(messages.encode(drift(seen)))
    assert sent["apparent_rad"] == round(turn, 5)
    assert (sent["shift_m"], sent["pairs"], sent["corners"], sent["alarm"]) == (-0.0041, 90, 9, True)
    assert sent["words"] == seen.words
    assert drift(None) is None
