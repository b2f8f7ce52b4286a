"""The sensors of a body: as noisy, offset and late as they are said to be, and always the same."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.worlds.body.estimator import BodyReadings
from surefoot.worlds.body.sensors import BodyNoise

ARRAYS = ("joint_angles", "joint_velocities", "gyro", "accelerometer", "foot_force")
SILENT = BodyNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def perfect(cycle: int) -> BodyReadings:
    """Readings that tell in which cycle they were taken."""
    now = float(cycle)
    return BodyReadings(
        now, np.full(12, now), np.full(12, now), np.full(3, now), np.full(3, now), np.full(2, now)
    )


def told(noise: BodyNoise, cycles: int) -> list[BodyReadings]:
    memory, found = noise.start(), []
    for cycle in range(cycles):
        senses, memory = noise.step(memory, perfect(cycle))
        found.append(senses)
    return found


def errors(found: list[BodyReadings], name: str) -> np.ndarray:
    return np.array([getattr(senses, name) - senses.time for senses in found])


def test_without_noise_nothing_is_changed() -> None:
    for cycle, senses in enumerate(told(SILENT, 5)):
        for name in ARRAYS:
            assert (getattr(senses, name) == cycle).all()


def test_the_noise_is_as_large_as_it_is_said_to_be() -> None:
    found = told(BodyNoise(0.002, 0.2, 0.02, 0.3, 0.0, 4.0, seed=3), 3000)[100:]
    for name, deviation in zip(ARRAYS, (0.002, 0.2, 0.02, 0.3, 4.0), strict=True):
        error = errors(found, name)
        assert error.std() == pytest.approx(deviation, rel=0.05), name
        assert np.abs(error.mean(axis=0)).max() < 5.0 * deviation / len(found) ** 0.5, name
        one, other = error[:, 0], error[:, 1]
        assert abs(np.corrcoef(one, other)[0, 1]) < 0.07, "channels are independent"
        assert abs(np.corrcoef(one[1:], one[:-1])[0, 1]) < 0.07, "it is white"


def test_the_gyroscopes_offset_stays() -> None:
    offsets = [
        errors(told(BodyNoise(0.0, 0.0, 0.0, 0.0, 0.01, 0.0, seed=seed), 3), "gyro")
        for seed in range(100)
    ]
    assert (np.ptp(offsets, axis=1) < 1e-12).all()
    assert np.std([offset[0] for offset in offsets]) == pytest.approx(0.01, rel=0.2)


def test_a_foot_never_pulls() -> None:
    found = told(BodyNoise(force=50.0), 100)
    assert min(senses.foot_force.min() for senses in found) == 0.0


def test_what_is_told_is_late() -> None:
    late = BodyNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, delay=0.005)
    assert [senses.time for senses in told(late, 9)] == [0, 0, 0, 0, 0, 0, 1, 2, 3]
    noisy = told(BodyNoise(delay=0.005), 9)
    assert noisy[5] is not None
    assert (noisy[6].gyro == told(BodyNoise(), 9)[1].gyro).all(), "drawn when it is sensed"


def test_the_seed_decides() -> None:
    one, same, other = (told(BodyNoise(seed=seed), 3)[-1] for seed in (1, 1, 2))
    for name in ARRAYS:
        assert getattr(one, name).tobytes() == getattr(same, name).tobytes()
        assert (getattr(one, name) != getattr(other, name)).all()


def test_wrong_parameters_are_refused() -> None:
    with pytest.raises(sf.ParameterError, match="`gyro` of at least 0"):
        BodyNoise(gyro=-1.0)
    with pytest.raises(sf.ParameterError, match="`seed` as a whole number"):
        BodyNoise(seed=-1)
    with pytest.raises(sf.ParameterError, match="whole number of periods"):
        BodyNoise(delay=0.0005)
