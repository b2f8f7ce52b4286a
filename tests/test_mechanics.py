"""The mechanism's quantities: the Jacobians of the soles are those of MuJoCo."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.mechanics import Mechanics


def test_jacobians_and_their_rates_are_those_of_mujoco(multibody: Multibody) -> None:
    model, rng = multibody.model, np.random.default_rng(0)
    mechanics, data = Mechanics(multibody), mujoco.MjData(model)
    for _ in range(50):
        data.qpos[:], data.qvel[:] = multibody.nominal, rng.normal(size=model.nv)
        mujoco.mj_integratePos(model, data.qpos, rng.normal(0.0, 0.5, model.nv), 1.0)
        mechanics.update(data.qpos, data.qvel)
        mujoco.mj_forward(model, data)
        for side, (site, foot) in enumerate(zip(multibody.soles, multibody.feet, strict=True)):
            jacobian, rate = np.zeros((6, model.nv)), np.zeros((6, model.nv))
            mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
            mujoco.mj_jacDot(model, data, rate[:3], rate[3:], data.site_xpos[site], foot)
            assert mechanics.sole_jacobian[side] == pytest.approx(jacobian, rel=0.0, abs=1e-12)
            assert mechanics.sole_drift[side] == pytest.approx(rate @ data.qvel, abs=1e-10)
